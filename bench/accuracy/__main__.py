"""Errors of ways to compute a scene against their time: see ``table.py``."""

import sys

from table import main

sys.exit(main())
