"""A user's fabric file, for tests that change something in it."""

GOOD = """\
name = "mine"

[areal_density]
value = 300
unit = "g/m^2"
status = "measured"
source = "own scales"

[thickness]
value = 0.3
unit = "mm"
status = "measured"
source = "own gauge"

[yarns_warp]
value = 5
unit = "1/cm"
status = "measured"
source = "counted"

[cell_warp]
value = 2.5
unit = "mm"
status = "measured"
source = "counted"

[tension]
law = "linear"
warp = { value = 40, unit = "kN", status = "assumed", source = "a guess" }
weft = { value = 50, unit = "kN", status = "assumed", source = "a guess" }

[shear]
law = "table"

[shear.angles]
value = [0, 10, 30, 60]
unit = "deg"
status = "measured"
source = "picture frame"

[shear.couples]
value = [0, 0.1, 0.2, 0.9]
unit = "N*mm"
status = "measured"
source = "picture frame"
"""
TOLD = 'status = "measured", source = "own test"'


def writer(tmp_path):
    """A function that writes the file with replacements, each once, and returns its path."""

    def write(*replacements):
        text = GOOD
        for old, new in replacements:
            assert old in text
            text = text.replace(old, new, 1)
        path = tmp_path / "mine.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write
