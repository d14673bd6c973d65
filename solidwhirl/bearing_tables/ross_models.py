"""Film models of ROSS, computed in an environment of its own."""

from __future__ import annotations

import contextlib
import json
import math
import os
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from solidwhirl.bearing_tables.grid import GridError, on_grid
from solidwhirl.bearing_tables.records import (
    AxialCoefficients,
    CoefficientTable,
    TableFileError,
    text_of,
)
from solidwhirl.bearing_tables.ross_files import loaded
from solidwhirl.core.errors import UserError, choice
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.units import RAD_S_PER_RPM

_SCRIPT = Path(__file__).with_name("ross_script.py")
_FOUND = "import importlib.util, sys; sys.exit(importlib.util.find_spec('ross') is None)"
# Models whose axis is the frequency of the motion.
_OVER_FREQUENCY = ("SqueezeFilmDamper", "MagneticBearingElement")
_MOST_SPEEDS = 2001
# Time that ROSS may take to be found, and to compute a film [s].
_FINDING_S, _COMPUTING_S = 60, 3600


def speeds_of(text: str) -> FloatArray:
    """Return speeds in rad/s from FROM:TO:STEP in rpm, ends included.

    Raises UserError: not three numbers with 0 < FROM < TO and a step that fits between.
    """
    try:
        first, last, step = (float(part) for part in text.split(":"))
    except ValueError:
        first = last = step = math.nan
    if not (0 < first < last < math.inf and 0 < step <= last - first):
        raise UserError(
            f"--speeds: found {text!r}, allowed is FROM:TO:STEP in rpm, as 3000:12000:1000"
        )
    count = int((last - first) / step * (1 + 1e-12)) + 1
    if count > _MOST_SPEEDS:
        raise UserError(f"--speeds: found {count} speeds, allowed is {_MOST_SPEEDS}")
    return np.asarray((first + step * np.arange(count)) * RAD_S_PER_RPM)


class Film(NamedTuple):
    """What a film model gives: across the axis, and along it; None where it has nothing."""

    across: CoefficientTable | None
    along: AxialCoefficients | None


def film_of(path: Path, speeds_rad_s: FloatArray, python: Path | None) -> Film:
    """Return what a film model of ROSS gives at some speeds.

    `path`: TOML with `model`, a class of ROSS such as "CylindricalBearing", and `[arguments]`,
    those of the class without `n` and the speeds, in SI or as { value = 30, unit = "mm" };
    `python`: of ROSS's environment.
    Raises TableFileError: the file, the model or its arguments are refused, or ROSS fails or gives
    no coefficients; UserError: no environment has ROSS.
    """
    request = _request(path) | {"speeds_rad_s": speeds_rad_s.tolist()}
    reply = _run(path, ross_python(python), request)
    if "error" in reply:
        raise TableFileError(path, str(reply["error"]))
    axis = np.array(reply["axis_rad_s"], dtype=float)
    values = {k: np.array(v, dtype=float) for k, v in reply["coefficients"].items() if v}
    columns = {k: np.broadcast_to(v, axis.shape) for k, v in values.items()}
    unknown = [k for k, column in columns.items() if not np.isfinite(column).all()]
    if unknown:
        raise TableFileError(path, f"{request['model']} gives no number for {', '.join(unknown)}")
    source = f"{path.name}: {request['model']} of ROSS {reply['version']}"
    across = {k: column for k, column in columns.items() if not k.endswith("zz")}
    along = {k: columns.get(k, np.zeros_like(axis)) for k in ("kzz", "czz")}
    found = Film(
        across=_across(path, request["model"], axis, across, source)
        if any(column.any() for column in across.values())
        else None,
        along=AxialCoefficients(
            speeds_rad_s=axis,
            stiffness_n_per_m=along["kzz"],
            damping_n_s_per_m=along["czz"],
            source=source,
        )
        if any(column.any() for column in along.values())
        else None,
    )
    if found == Film(None, None):
        raise TableFileError(path, f"{request['model']} gives no coefficients on ux, uy and uz")
    return found


def _across(
    path: Path, model: str, axis: FloatArray, columns: Mapping[str, FloatArray], source: str
) -> CoefficientTable:
    over = "frequencies_rad_s" if model in _OVER_FREQUENCY else "speeds_rad_s"
    try:
        found, matrices = on_grid({over: axis}, columns)
    except GridError as error:
        raise TableFileError(path, str(error)) from error
    return CoefficientTable(
        **found,  # type: ignore[arg-type]
        stiffness_n_per_m=matrices["k"],
        damping_n_s_per_m=matrices["c"],
        mass_kg=matrices["m"],
        source=source,
    )


def ross_python(given: Path | None) -> Path:
    """Return the Python of an environment that has ROSS: the one given, a path or on the PATH.

    Raises UserError: none is given, or it can not import ROSS within a minute.
    """
    install = "install ross-rotordynamics in an environment of its own and name its python"
    if given is None:
        raise UserError(f"--ross-python: missing; {install}")
    python = given.absolute() if given.exists() else given
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        words = [str(python), "-c", _FOUND]
        done = subprocess.run(words, check=False, capture_output=True, timeout=_FINDING_S)
        if done.returncode == 0:
            return python
    raise UserError(f"--ross-python: {given} can not import ross; {install}")


def _request(path: Path) -> dict[str, Any]:
    """The model and its arguments."""
    data = loaded(path, text_of(path))
    model, arguments = data.get("model"), data.get("arguments", {})
    if not isinstance(model, str) or not isinstance(arguments, dict):
        raise TableFileError(path, 'needs model = "CLASS" and a table [arguments]')
    for key in data:
        if key not in ("model", "arguments"):
            said = choice(key, ("model", "arguments"))
            raise TableFileError(path, f"{key}: unknown key; {said}")
    for key in ("n", "speed", "frequency"):
        if key in arguments:
            raise TableFileError(path, f"arguments.{key}: leave it out; --speeds gives the speeds")
    return {"model": model, "arguments": arguments}


def _run(path: Path, python: Path, request: dict[str, Any]) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        try:
            (folder / "request.json").write_text(json.dumps(request), encoding="utf-8")
        except TypeError as error:  # a date, which is no argument of a film
            raise TableFileError(path, f"arguments: {error}") from error
        # a copy, as Python looks for modules beside what it runs, and ROSS's may have our names
        script = folder / _SCRIPT.name
        script.write_bytes(_SCRIPT.read_bytes())
        try:
            done = subprocess.run(
                [python, script, folder / "request.json", folder / "reply.json"],
                check=False,
                capture_output=True,
                text=True,
                timeout=_COMPUTING_S,
                # the paths of this environment are not those of ROSS
                env={k: v for k, v in os.environ.items() if k != "PYTHONPATH"},
            )
        except subprocess.TimeoutExpired as error:
            said = f"ROSS has not ended after {_COMPUTING_S} s; ask for fewer --speeds"
            raise TableFileError(path, said) from error
        reply = folder / "reply.json"
        if done.returncode != 0 or not reply.exists():
            last = (done.stderr.strip().splitlines() or ["no message"])[-1]
            raise TableFileError(path, f"ROSS failed: {last}")
        found: dict[str, Any] = json.loads(reply.read_text(encoding="utf-8"))
        return found
