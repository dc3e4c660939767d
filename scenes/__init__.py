"""Runnable scenes; each module has ``build(**parameters) -> Scene``."""
