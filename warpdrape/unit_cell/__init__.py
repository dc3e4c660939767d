"""Materials from a unit cell: yarns of a weave as beams in contact, loaded, and what a card has of it."""
