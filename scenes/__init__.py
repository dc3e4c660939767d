"""Runnable scenes: each module has ``build(**parameters) -> Scene``, or is shared by some.

``warpdrape run NAME`` and ``python scenes/NAME.py`` are the same.
"""
