"""The geometrical approach: a pin-jointed net of inextensible yarns on a surface."""
