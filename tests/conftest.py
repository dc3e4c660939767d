"""Fixtures shared by all tests."""

import pytest
import warp as wp

from warpdrape.scenes import three_ply_hemisphere

wp.config.quiet = True


def devices():
    return ["cpu", *(["cuda:0"] if wp.get_cuda_device_count() else [])]


@pytest.fixture(scope="session")
def pressed(tmp_path_factory):
    """Three plies, a little pressed: the result and its run folder, to be read only."""
    folder = tmp_path_factory.mktemp("pressed") / "run"
    scene = three_ply_hemisphere.build(cells=6, travel=0.03, duration=0.01)
    return scene.run(folder, frames=4), folder


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
