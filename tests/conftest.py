"""Fixtures shared by all tests."""

import pytest
import warp as wp

wp.config.quiet = True


def devices():
    return ["cpu", *(["cuda:0"] if wp.get_cuda_device_count() else [])]


@pytest.fixture(params=devices())
def device(request):
    """Every device that computes here."""
    return request.param
