"""CalculiX decks of the spinning free rotor, and whirl frequencies from what CalculiX writes.

Three steps per speed: centrifugal stress (linear; statically determinate pins, which a balanced
body does not load), free vibration with that stress and without pins, whirl in the rotating frame.
"""

from __future__ import annotations

import math
import re
import shutil
import subprocess

RPM = math.pi / 30.0
STATIC = """*STEP
*STATIC
*BOUNDARY
{pins}
*DLOAD
BODY,CENTRIF,{square:.11e},0,0,0,0,0,1
*END STEP
"""
WHIRL = """*STEP, PERTURBATION
*BOUNDARY, OP=NEW
*FREQUENCY, STORAGE=YES
{modes}
*END STEP
*STEP, PERTURBATION
*COMPLEX FREQUENCY, CORIOLIS
{modes}
*END STEP
"""
AT_REST = "*STEP\n*FREQUENCY\n{modes}\n*END STEP\n"
MATRICES = "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n*END STEP\n"


def program() -> tuple[str, str]:
    """Path and version of CalculiX."""
    path = shutil.which("ccx")
    if path is None:
        raise SystemExit("peers: CalculiX is missing; `tools/setup.sh verify` installs it")
    said = subprocess.run([path, "-v"], capture_output=True, text=True, check=False).stdout
    return path, said.split("Version")[-1].strip()


def steps(pins: list[str], speeds_rpm: list[float], modes: int) -> str:
    """Steps of all speeds of one job."""
    texts = []
    for rpm in speeds_rpm:
        if rpm == 0.0:
            texts.append(AT_REST.format(modes=modes))
            continue
        texts.append(STATIC.format(pins="\n".join(pins), square=(rpm * RPM) ** 2))
        texts.append(WHIRL.format(modes=modes))
    return "".join(texts)


def _rows(section: str, columns: int) -> list[list[float]]:
    """Numbers of the table an output section begins with."""
    rows = []
    for line in section.splitlines():
        words = line.split()
        if len(words) == columns and re.fullmatch(r"\d+", words[0]):
            rows.append([float(w) for w in words[1:]])
        elif rows and words:
            break
    return rows


def read_frequencies(text: str, speeds_rpm: list[float]) -> list[list[float]]:
    """Inertial frequencies of every speed [Hz], ascending.

    CalculiX works in the rotating frame: lateral forward whirl is faster by the spin in the
    inertial frame, backward whirl slower. Modes of other circumferential orders shift by other
    multiples; they are converted as lateral ones and do not matter here.
    """
    tables = text.split("E I G E N V A L U E   O U T P U T")[1:]
    found = []
    for rpm in speeds_rpm:
        free = tables.pop(0)
        if rpm == 0.0:
            values = [row[2] for row in _rows(free, 5)]
        else:
            whirl = tables.pop(0)
            spin = rpm / 60.0
            rotating = [row[1] for row in _rows(whirl, 4)]
            turning = re.findall(r"^ +(\d+) +([FB])\s*$", whirl, re.MULTILINE)
            signs = {int(number): 1.0 if way == "F" else -1.0 for number, way in turning}
            # without a direction it is no mode: the Newton iteration stopped short
            values = [abs(rotating[n - 1] + s * spin) for n, s in signs.items()]
        found.append(sorted(values))
    return found
