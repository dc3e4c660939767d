"""Defects of formed plies as numbers: wrinkles, bridging, thickness, yarns, draw-in."""
