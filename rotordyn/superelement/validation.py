"""Names and checks that all parts of a superelement share: components, levels, arrays, JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, Literal, get_args

import numpy as np

from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.rotordyn.core.errors import SuperelementError

Component = Literal["ux", "uy", "uz", "rx", "ry", "rz", "q"]
Level = Literal["solid", "harmonic", "beam", "lumped", "imported"]
Frame = Literal["inertial", "rotating"]
Coupling = Literal["rigid", "distributing", "none"]

MOTIONS: tuple[Component, ...] = ("ux", "uy", "uz", "rx", "ry", "rz")
LEVELS: tuple[Level, ...] = get_args(Level)
FRAMES: tuple[Frame, ...] = get_args(Frame)
COUPLINGS: tuple[Coupling, ...] = get_args(Coupling)
SYMMETRIC_MATRICES = ("mass", "stiffness", "stress_stiffening", "spin_softening")
SYMMETRY_LIMIT = 1e-10
# Levels of tables and lists in a provenance.
_DEEPEST = 64


def finite_array(where: str, name: str, value: Any, shape: tuple[int | None, ...]) -> FloatArray:
    """Return a read-only float copy of the given shape."""
    try:
        array = np.array(value, dtype=np.float64, order="C")
    except (TypeError, ValueError) as error:
        raise SuperelementError(f"{where}: {name} is not an array of numbers: {error}") from error
    fits = array.ndim == len(shape) and all(
        want is None or have == want for have, want in zip(array.shape, shape, strict=True)
    )
    if not fits:
        text = "(" + ", ".join("any" if length is None else str(length) for length in shape) + ")"
        raise SuperelementError(f"{where}: {name} has shape {array.shape}, allowed is {text}")
    if not np.isfinite(array).all():
        bad = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise SuperelementError(
            f"{where}: {name}{list(bad)} is {array[bad]}; all numbers must be finite"
        )
    array.setflags(write=False)
    return array


def symmetrised(where: str, name: str, matrix: FloatArray, sign: float) -> FloatArray:
    """Return the exactly symmetric (sign 1) or skew (sign -1) matrix, refusing a bad one."""
    # scaled, so that no sum overflows
    largest = float(np.abs(matrix).max(initial=0.0)) or 1.0
    error = float(np.abs(matrix / largest - sign * (matrix.T / largest)).max(initial=0.0))
    if error > SYMMETRY_LIMIT:
        kind = "symmetric" if sign > 0 else "skew"
        raise SuperelementError(
            f"{where}: {name} is not {kind}: largest deviation {error:.3e} of its "
            f"largest entry, allowed is {SYMMETRY_LIMIT:g}"
        )
    exact: FloatArray = np.ascontiguousarray(0.5 * (matrix + sign * matrix.T))
    exact.setflags(write=False)
    return exact


def part_of_body(where: str, name: str, part: Any, kind: type[Any], n: int) -> Any:
    """Return a part of a body with n coordinates, or None; refuse that of another body."""
    if part is None:
        return None
    if not isinstance(part, kind):
        raise SuperelementError(
            f"{where}: {name} is a {type(part).__name__}, allowed are {kind.__name__}, or None"
        )
    if part.size != n:
        raise SuperelementError(f"{where}: {name} is of {part.size} coordinates, allowed are {n}")
    return part


def plain_json(where: str, provenance: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy made of JSON types only, nested no deeper than can be read again."""
    try:
        text = json.dumps(dict(provenance), allow_nan=False, ensure_ascii=False)
        text.encode()
        plain = dict(json.loads(text))
    except RecursionError as error:
        raise SuperelementError(f"{where}: provenance is nested too deeply") from error
    except (TypeError, ValueError) as error:
        raise SuperelementError(
            f"{where}: provenance must be made of what JSON can hold: {error}"
        ) from error
    level: list[Any] = [plain]
    for _ in range(_DEEPEST):
        inside = [v.values() if isinstance(v, dict) else v for v in level]
        level = [v for values in inside for v in values if isinstance(v, dict | list)]
    if level:
        raise SuperelementError(
            f"{where}: provenance is nested too deeply; {_DEEPEST} levels are allowed"
        )
    return plain
