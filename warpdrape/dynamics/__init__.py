"""From a scene to arrays, and the explicit steps that move them."""
