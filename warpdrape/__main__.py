"""``python -m warpdrape`` is ``warpdrape``."""

from warpdrape.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
