"""Rigid tools: their surfaces and how they move."""
