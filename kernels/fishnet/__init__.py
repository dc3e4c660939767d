"""A pin-jointed net on a triangulated surface: straight ways across facets, and crossovers."""
