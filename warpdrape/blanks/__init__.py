"""A ply before it is formed: outline, mesh, pairs of triangles."""
