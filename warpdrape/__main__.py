"""``python -m warpdrape`` is ``warpdrape``."""

import os
import sys

if not sys.flags.safe_path and sys.path and sys.path[0] in ("", os.getcwd()):
    del sys.path[0]  # the folder of a run is no place from which to import numpy, or anything

from warpdrape.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
