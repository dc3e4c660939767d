"""Motion of vertices and tools."""
