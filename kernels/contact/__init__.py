"""Searches and forces of contact."""
