"""Make the reference of the Python API from its docstrings: `python docs/api.py [FOLDER]`.

It needs pdoc (`pip install warpdrape[docs]`) and leaves a folder of pages to open in a browser.
"""

import sys
from pathlib import Path

import pdoc

MODULES = ["warpdrape", "!warpdrape\\..*", "warpdrape.laws", "warpdrape.units"]
"""What users import; the rest is for those who read the source."""


def make(folder: Path) -> Path:
    """Write the pages into a folder and return the first one."""
    pdoc.render.configure(docformat="google", show_source=False, footer_text="warpdrape")
    pdoc.pdoc(*MODULES, output_directory=folder)
    return folder / "warpdrape.html"


if __name__ == "__main__":
    print(make(Path(sys.argv[1] if len(sys.argv) > 1 else "build/api")))
