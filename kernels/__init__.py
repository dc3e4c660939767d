"""Warp kernels and functions: the formulas, and nothing but `warp` beside them."""
