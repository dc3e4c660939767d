"""Cases with known answers, above the scenes; ``warpdrape verify`` runs them."""
