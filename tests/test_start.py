"""The start of a run: no garbage is looked for while modules are imported, but afterwards it is."""

import gc

import pytest

from warpdrape.commands.running import _garbage_left


def test_garbage_is_looked_for_again_after_imports():
    try:
        with _garbage_left():
            assert not gc.isenabled()
        assert gc.isenabled() and gc.get_freeze_count() > 0
        with pytest.raises(ImportError), _garbage_left():
            raise ImportError("no such module")
        assert gc.isenabled()
    finally:
        gc.unfreeze()
