"""Warp kernels and functions: the formulas, and nothing but `warp` beside them."""

import warp as wp

wp.config.log_level = wp.LOG_ERROR  # before Warp starts, wherever the first kernel is used from
