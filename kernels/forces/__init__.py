"""Internal forces of plies."""
