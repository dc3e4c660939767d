"""What a scene will do, from its geometry alone, before it is run."""
