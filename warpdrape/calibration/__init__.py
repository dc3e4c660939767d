"""Materials from raw tests: laboratory tables in, a fabric's card with bands out."""
