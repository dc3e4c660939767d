"""``warpdrape info``: versions, devices and the kernel cache."""

from __future__ import annotations

import argparse
import os

from warpdrape.command_line.command import DONE, Command


def _act(_: argparse.Namespace) -> int:
    import platform

    import warp as wp

    from warpdrape.results.run_record import versions
    from warpdrape.warp_start import start_warp

    start_warp()
    for name, version in versions().items():
        print(f"{name:12} {version}")
    print(f"{'system':12} {platform.platform()}, {os.cpu_count()} logical cores")
    for device in wp.get_devices():
        memory = f", {device.total_memory / 2**30:.0f} GiB" if device.is_cuda else ""
        print(f"{'device':12} {device.alias} ({device.name}{memory})")
    if not wp.is_cuda_available():
        print(f"{'':12} no CUDA device: a run uses the processor")
    print(f"{'kernel cache':12} {wp.config.kernel_cache_dir}")
    return DONE


COMMAND = Command(
    name="info",
    words="show versions, devices and the kernel cache",
    act=_act,
)
