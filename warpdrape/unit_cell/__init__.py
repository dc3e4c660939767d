"""Materials from a unit cell: a weave as beams in contact, pulled and sheared."""
