"""The report's page: one file with its styles, scripts and data, which asks for nothing else.

A content security policy in its head lets only the scripts run whose digests it names, and forbids
every connection: text that came from a run folder could not act even where it were not escaped.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from importlib import resources
from typing import Any

from warpdrape.report.markup import Html, element, joined, json_block

_VENDOR_SCRIPTS = ("three.min.js", "uplot.min.js")
_SCRIPTS = (
    "decode.js",
    "colours.js",
    "ply_view.js",
    "run_view.js",
    "cut.js",
    "stage.js",
    "difference.js",
    "plots.js",
    "pointer.js",
    "controls.js",
    "main.js",
)
"""In the order in which they need each other."""
_STYLES = (("vendor", "uplot.min.css"), ("assets", "style.css"))


def page(
    title: str,
    lines: Sequence[Html],
    sections: Sequence[tuple[str, str, Html]],
    data: Any,
    blocks: Sequence[str],
) -> str:
    """Return the page.

    Args:
        title: of the page.
        lines: below it.
        sections: id, heading and content of what follows the 3-D view and the plots.
        data: what ``assets/main.js`` is told.
        blocks: packed numbers in base64, as in `warpdrape.report.packing`.
    """
    scripts = [_file("vendor", name) for name in _VENDOR_SCRIPTS]
    scripts.append("\n".join(_file("assets", name) for name in _SCRIPTS))
    style = "\n".join(_file(*style) for style in _STYLES)
    content = [
        element("section", element("h2", heading), inside, id=name)
        for name, heading, inside in sections
    ]
    numbers = (
        Html(f'<script type="text/plain" id="block-{k}">{text}</script>')
        for k, text in enumerate(blocks)
    )
    parts = [
        Html('<!doctype html>\n<html lang="en">\n<head>'),
        Html(_META),
        _policy(scripts, style),
        element("title", title),
        Html(f"<style>{style}</style>\n</head>\n<body>"),
        _head(title, lines, sections),
        Html(_VIEW),
        element("section", element("h2", "Over time"), Html(_PLOTS), id="curves"),
        *content,
        json_block("data", data),
        *numbers,
        *(Html(f"<script>{script}</script>") for script in scripts),
        Html("</body>\n</html>\n"),
    ]
    return joined(parts, "\n")


def _policy(scripts: Sequence[str], style: str) -> Html:
    """What the page may do: run its own scripts, and nothing else."""
    rules = (
        "default-src 'none'",
        f"script-src {_allowed(scripts)}",
        f"style-src {_allowed([style])}",
        "img-src data: blob:",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return Html(f'<meta http-equiv="Content-Security-Policy" content="{"; ".join(rules)}">')


def licences() -> Html:
    """What of others the page holds, under which licences; their texts must go with it."""
    words = "The page holds three.js and uPlot, and asks for nothing over the network; licences"
    texts = (element("pre", _file("vendor", f"{name}.LICENSE")) for name in ("three", "uplot"))
    return element("details", element("summary", words), *texts)


def _head(title: str, lines: Sequence[Html], sections: Sequence[tuple[str, str, Html]]) -> Html:
    places = [("view-section", "3-D view"), ("curves", "Over time")]
    places += [(name, heading) for name, heading, _ in sections]
    links = (element("a", heading, href=f"#{name}") for name, heading in places)
    contents = element("nav", *links, aria_label="Contents")
    return element("header", element("h1", title), *lines, contents)


def _allowed(texts: Sequence[str]) -> str:
    digests = (hashlib.sha256(text.encode("utf-8")).digest() for text in texts)
    return " ".join(f"'sha256-{base64.b64encode(d).decode('ascii')}'" for d in digests)


def _file(folder: str, name: str) -> str:
    path = resources.files("warpdrape.report").joinpath(folder, name)
    return path.read_text(encoding="utf-8")


_META = """<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">"""
_LEGEND = (
    '<span class="title"></span><canvas class="bar" aria-hidden="true"></canvas>'
    '<div class="ticks"><span></span><span></span><span></span><span></span><span></span></div>'
)
_VIEW = f"""<section id="view-section">
<h2>3-D view</h2>
<noscript><p class="trouble">The 3-D view and the plots need JavaScript; tables and words do \
not.</p></noscript>
<p class="trouble" id="no-webgl" hidden>This browser shows no WebGL, so that there is no 3-D view \
here: open the file in another one.</p>
<p class="trouble" id="trouble" role="alert" hidden></p>
<div id="view">
<div class="controls">
<label>Colour by <select id="field"></select></label>
<label id="mode-label" hidden>showing <select id="mode"></select></label>
<label>from <input type="number" step="any" id="low" aria-label="low end of the scale"></label>
<label>to <input type="number" step="any" id="high" aria-label="high end of the scale"></label>
<fieldset id="plies"><span>Plies</span></fieldset>
<fieldset id="tools"><span>Tools</span></fieldset>
<label><input type="checkbox" id="yarns" checked> Yarns: warp <span class="key warp"></span> weft \
<span class="key weft"></span></label>
<label>Look from <select id="look"></select></label>
<label>Lift plies apart <input type="range" id="spread" min="0" max="100" value="0"></label>
<label>Cut across <select id="cut-axis"><option value="">nothing</option><option value="0">x\
</option><option value="1">y</option><option value="2">z</option></select></label>
<input type="range" id="cut-place" min="0" max="500" value="250" aria-label="place of the cut">
<span id="cut-words"></span>
<label><input type="checkbox" id="cut-other"> other side</label>
<button type="button" id="save">Save picture</button>
</div>
<div class="stage">
<canvas id="canvas" role="img" aria-label="plies and tools, coloured by the field chosen; drag to \
turn, right-drag to move, wheel to zoom"></canvas>
<div id="names"></div>
<div id="tip" hidden></div>
</div>
<div class="time">
<button type="button" id="play">Play</button>
<input type="range" id="time" min="0" max="1" step="1" value="1" aria-label="time">
</div>
<output id="moment" for="time"></output>
<div class="legends">
<div class="legend" id="legend">{_LEGEND}</div>
<div class="legend" id="difference-legend" hidden>{_LEGEND}</div>
</div>
<p class="faint">Drag to turn, right-drag to move, wheel to zoom; point at a ply for its values; \
arrow keys move the time once it has the focus.</p>
</div>
</section>"""
_PLOTS = """<p class="faint">The upright line is the moment of the 3-D view; a click goes there. \
Drag to zoom, double-click to see all. A click on a name hides a curve.</p>
<div id="plots"></div>"""
