"""The reference that is built from docstrings: every public name is in it, with its words."""

import importlib.util
import inspect
import re
from pathlib import Path

import pytest

import warpdrape
from warpdrape import laws

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    pytest.importorskip("pdoc")
    spec = importlib.util.spec_from_file_location("api", ROOT / "docs" / "api.py")
    api = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(api)
    folder = tmp_path_factory.mktemp("api")
    first = api.make(folder)
    assert first.is_file()
    made = {path.relative_to(folder).as_posix() for path in folder.rglob("*.html")}
    assert made == {"index.html", "warpdrape.html", "warpdrape/laws.html", "warpdrape/units.html"}
    return {name: (folder / name).read_text("utf-8") for name in made}


@pytest.mark.parametrize(
    ("page", "module"), [("warpdrape.html", warpdrape), ("warpdrape/laws.html", laws)]
)
def test_every_public_name_is_there_with_its_docstring(pages, page, module):
    words = " ".join(re.sub(r"<[^>]+>", " ", pages[page]).split())
    for name in module.__all__:
        thing = getattr(module, name)
        if inspect.ismodule(thing):
            continue
        assert f'id="{name}"' in pages[page], name
        first = re.split(r"[`&<>]", inspect.getdoc(thing).splitlines()[0])[0]
        assert len(first) > 5 and " ".join(first.split()) in words, name


def test_methods_are_there_and_private_names_are_not(pages):
    page = pages["warpdrape.html"]
    for member in ("Ply.rectangle", "Scene.run", "Tool.from_mesh", "Result.plot"):
        assert f'id="{member}"' in page
    assert not re.search(r'id="Ply\._[a-z]', page)
