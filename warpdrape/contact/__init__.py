"""What contact searches need to know of plies and tools."""
