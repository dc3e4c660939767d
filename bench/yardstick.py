"""The plain C loop that every figure is a ratio to."""

from __future__ import annotations

import re
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Yardstick:
    """`calib.c`, compiled in double precision with shear."""

    program: Path

    @classmethod
    def build(cls) -> Yardstick:
        """Compile it with the system's C compiler."""
        source = Path(__file__).with_name("calib.c")
        program = Path(tempfile.mkdtemp()) / "calib"
        command = ["cc", "-O3", "-march=native", "-DREAL=double", "-DSHEAR"]
        try:
            subprocess.run([*command, str(source), "-o", str(program), "-lm"], check=True)
        except (OSError, subprocess.CalledProcessError) as error:
            raise SystemExit(
                f"cannot compile {source.name}: {error}; install a C compiler"
            ) from None
        return cls(program)

    def rate(self, steps: int = 400) -> float:
        """Triangle-steps per second of processor time, 80,000 triangles."""
        command = [str(self.program), "200", "200", str(steps)]
        text = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        return float(re.search(r"\(cpu ([\d.e+]+)\)", text).group(1))
