"""Scenes by name or by path: finding them, describing their parameters, building them."""

from __future__ import annotations

import ast
import hashlib
import importlib
import importlib.util
import inspect
import os
import sys
import types
import typing
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path
from typing import Any

from warpdrape.commands.scene_parameters import Parameter, read_parameters, shown
from warpdrape.errors import InputError, nearest, one_of

if typing.TYPE_CHECKING:
    from warpdrape.scene import Scene


@dataclass(frozen=True)
class SceneScript:
    """A scene that can be built.

    Attributes:
        name: a bundled name, or the stem of the script.
        title: first line of the module's docstring.
        build: the function that returns the scene.
        parameters: its parameters by name, in their order.
        path: the script.
        bundled: whether it comes with the package.
        digest: of the script's text; empty for a bundled one.
    """

    name: str
    title: str
    build: Callable[..., Scene]
    parameters: Mapping[str, Parameter]
    path: Path
    bundled: bool
    digest: str = ""

    def read_settings(self, settings: Sequence[str]) -> dict[str, Any]:
        """Read texts ``NAME=VALUE``; the last one counts where a name is given twice.

        Raises:
            InputError: unknown name (the nearest known is given) or a value of another type.
        """
        values = {}
        for setting in settings:
            name, equals, text = (part.strip() for part in setting.partition("="))
            if not equals or not name:
                raise InputError(f"--set {setting}: write NAME=VALUE, without spaces round the =")
            if name not in self.parameters:
                raise InputError(
                    f"scene {self.name!r} has no parameter {name!r}{nearest(name, self.parameters)}"
                )
            values[name] = self.parameters[name].read(text)
        return values

    def make(self, settings: Sequence[str] = ()) -> Scene:
        """Build the scene with parameters as texts ``NAME=VALUE``.

        Raises:
            InputError: what `read_settings` refuses, a value that the scene refuses, or a script
                that fails.
        """
        from warpdrape.scene import Scene

        given = self.read_settings(settings)
        with _script_faults(self.path, "build()"):
            scene = self.build(**given)
        if not isinstance(scene, Scene):
            raise InputError(
                f"scene script {self.path}: build() returned {type(scene).__name__}: "
                "it must return a warpdrape.Scene"
            )
        if not self.bundled:
            scene = replace(scene, script=os.fspath(self.path))
        scene = replace(scene, call=self._call(settings))
        if scene.parameters:
            return scene
        used = {p.name: given.get(p.name, p.default) for p in self.parameters.values()}
        return replace(scene, parameters={n: _recorded(value) for n, value in used.items()})

    def _call(self, settings: Sequence[str]) -> dict[str, Any]:
        """What ``warpdrape resume`` needs to build it again."""
        path = self.path.resolve()
        return {
            "scene": self.name if self.bundled else os.fspath(path),
            "digest": self.digest,
            "settings": list(settings),
            "extensions": [],
        }


def _recorded(value: Any) -> Any:
    """A parameter as ``run.json`` has it: numbers, texts and lists of them, else in words."""
    if isinstance(value, list | tuple):
        return [_recorded(entry) for entry in value]
    return value if isinstance(value, float | int | str | None) else repr(value)


def bundled_scenes() -> dict[str, str]:
    """Names of the bundled scenes with the first line of their docstrings, sorted; runs no code."""
    titles = {}
    for file in resources.files("warpdrape.scenes").iterdir():
        if not file.name.endswith(".py") or file.name.startswith("_"):
            continue
        tree = ast.parse(file.read_text(encoding="utf-8"))
        if any(isinstance(node, ast.FunctionDef) and node.name == "build" for node in tree.body):
            titles[file.name.removesuffix(".py")] = _first_line(ast.get_docstring(tree))
    return dict(sorted(titles.items()))


def find_script(name_or_path: str | os.PathLike[str]) -> SceneScript:
    """Return a bundled scene by name, or one from a script.

    Args:
        name_or_path: a bundled name; or the path of a script: it ends in .py or holds a slash.

    Raises:
        InputError: unknown name (the nearest known is given), no such script, or one that fails or
            has no usable ``build``.
    """
    given = os.fspath(name_or_path)
    path = Path(given)
    bundled = bundled_scenes()
    if given not in bundled and (path.suffix == ".py" or len(path.parts) > 1 or path.is_file()):
        return _script(path, bundled)
    one_of("scene", given, bundled)
    module = importlib.import_module(f"warpdrape.scenes.{given}")
    return _described(given, module, bundled=True)


def find_typed(typed: str) -> SceneScript:
    """Return the scene that someone names on the command line: `find_script`, or a script by stem.

    Only what is typed may mean a script of the current folder without its ending: a name that a
    run folder holds must not.

    Args:
        typed: a bundled name, the path of a script, or that without its ``.py``.
    """
    script = Path(f"{typed}.py")
    if typed not in bundled_scenes() and not Path(typed).exists() and script.is_file():
        return find_script(script)
    return find_script(typed)


def _script(path: Path, bundled: Mapping[str, str]) -> SceneScript:
    if not path.is_file():
        kind = "is a folder" if path.is_dir() else "does not exist"
        hint = f"; the bundled scene is called {path.stem!r}" if path.stem in bundled else ""
        raise InputError(f"scene script {path} {kind}{hint or ': give the path of a .py file'}")
    spec = importlib.util.spec_from_file_location(f"_scene_script_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise InputError(f"scene script {path} is no Python file: its name must end in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    digest = digest_of(path)
    with _script_faults(path, "the script"):
        spec.loader.exec_module(module)
    return replace(_described(path.stem, module, bundled=False), digest=digest)


def digest_of(path: Path) -> str:
    """Of a script's text; empty if it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


def _described(name: str, module: types.ModuleType, *, bundled: bool) -> SceneScript:
    path = Path(str(module.__file__))
    build = getattr(module, "build", None)
    if not inspect.isfunction(build):
        raise InputError(
            f"scene script {path} has no function build(): define build(**parameters) that returns "
            "a warpdrape.Scene"
        )
    try:
        parameters = read_parameters(build)
    except InputError as error:
        raise InputError(f"scene script {path}: {error}") from None
    return SceneScript(name, _first_line(module.__doc__), build, parameters, path, bundled)


def describe_scene(script: SceneScript) -> str:
    """Return title and parameters, with defaults and units, as text for a terminal."""
    rows = [
        (f"  {p.name}", "" if p.kind is None else shown(p.default), p.description)
        for p in script.parameters.values()
    ]
    widths = [max((len(row[k]) for row in rows), default=0) for k in (0, 1)]
    heading = f"{script.name}: {script.title}"
    if not rows:
        return f"{heading}\n\nIt has no parameters."
    table = [f"{a:{widths[0]}}  {b:{widths[1]}}  {c}".rstrip() for a, b, c in rows]
    return "\n".join([heading, "", "Parameters (--set NAME=VALUE) with their defaults:", *table])


def _first_line(docstring: str | None) -> str:
    return (docstring or "").strip().partition("\n")[0]


@contextmanager
def _script_faults(path: Path, what: str) -> Iterator[None]:
    """Turn whatever a script raises into one line that names script and line.

    The script's folder is importable meanwhile, as when Python runs it.
    """
    folder = str(path.resolve().parent)
    sys.path.insert(0, folder)
    try:
        yield
    except (InputError, KeyboardInterrupt):
        raise
    except MemoryError as error:
        raise InputError(
            f"scene script {path}: {what} ran out of memory: take fewer cells or larger facets"
        ) from error
    except SyntaxError as error:
        where = f"scene script {error.filename}, line {error.lineno}"
        raise InputError(f"{where}: {error.msg}") from error
    except (Exception, SystemExit) as error:
        line = _line_in(path, error)
        where = f"scene script {path}" + (f", line {line}" if line else "")
        text = " ".join(str(error).split()) or "no message"
        raise InputError(f"{where}: {what} raised {type(error).__name__}: {text}") from error
    finally:
        if folder in sys.path:
            sys.path.remove(folder)


def _line_in(path: Path, error: BaseException) -> int | None:
    """Line of the script from which the error came, the innermost one."""
    line, step = None, error.__traceback__
    while step is not None:
        if Path(step.tb_frame.f_code.co_filename).name == path.name:
            line = step.tb_lineno
        step = step.tb_next
    return line
