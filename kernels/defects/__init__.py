"""Kernels of defects: what of them is asked point by point."""
