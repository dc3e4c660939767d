"""Laws of fabrics and sheets, energy and force side by side."""
