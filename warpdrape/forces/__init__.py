"""Internal forces of a ply, one kind a module."""
