"""Cases with known answers; ``warpdrape.verify`` runs them. It sits above the scenes."""
