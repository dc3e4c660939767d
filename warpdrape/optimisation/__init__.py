"""The best settings of a scene: what is to be best, where to look next, what was gained."""
