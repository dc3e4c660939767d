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


@pytest.fixture(scope="session")
def server(tmp_path_factory):
    """A warm interpreter whose forks run commands that are killed, or whose disk fails."""
    from fault_checks import Server

    server = Server(tmp_path_factory.mktemp("server"))
    yield server
    server.close()


@pytest.fixture(scope="session")
def whole(server, tmp_path_factory):
    """A run that nothing happened to, and what running it again took."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    assert server.run(folder)["status"] == 0
    return folder, server.run(folder)
