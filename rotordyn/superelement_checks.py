"""Checks a superelement makes on itself when it is built; each names what it found."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.errors import SuperelementError

if TYPE_CHECKING:
    from solidwhirl.rotordyn.superelement import Superelement


Component = Literal["ux", "uy", "uz", "rx", "ry", "rz", "q"]
Level = Literal["solid", "harmonic", "beam", "lumped", "imported"]
Coupling = Literal["rigid", "distributing", "none"]

MOTIONS: tuple[Component, ...] = ("ux", "uy", "uz", "rx", "ry", "rz")
LEVELS: tuple[Level, ...] = get_args(Level)
COUPLINGS: tuple[Coupling, ...] = get_args(Coupling)
SYMMETRIC_MATRICES = ("mass", "stiffness", "stress_stiffening", "spin_softening")
SYMMETRY_LIMIT = 1e-10
# Inertias about three axes of a body: none above the sum of the others, to this.
_INERTIA_LIMIT = 1e-6
_LONGEST_NAME = 200
# Levels of tables and lists in a provenance.
_DEEPEST = 64


def array_shapes(element: Superelement, n: int) -> dict[str, tuple[int | None, ...]]:
    """Return the shape each array must have; None stands for any length."""
    points = np.shape(element.recovery_points_m)[0] if np.ndim(element.recovery_points_m) else 0
    square = dict.fromkeys((*SYMMETRIC_MATRICES, "gyroscopic"), (n, n))
    return {
        **square,
        "rigid_body_modes": (n, 6),
        "center_of_gravity_m": (3,),
        "inertia_kg_m2": (3, 3),
        "recovery_points_m": (None, 3),
        "recovery_modes": (points, 3, n),
        "free_frequencies_hz": (None,),
        "fixed_interface_frequencies_hz": (None,),
        "frequency_error_estimate": (None,),
    }


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


def check_names(element: Superelement, where: str) -> None:
    """Refuse names that are empty, long or can't be printed, repeated ones, an unknown level."""
    if not element.name:
        raise SuperelementError("a superelement has an empty name; give it one")
    names = [node.name for node in element.interfaces]
    for name in (element.name, *names):
        if len(name) > _LONGEST_NAME or not name.isprintable():
            raise SuperelementError(
                f"superelement: {name[:_LONGEST_NAME]!r} is no name; at most {_LONGEST_NAME} "
                "printable characters are allowed"
            )
    if element.level not in LEVELS:
        raise SuperelementError(f"{where}: level is {element.level!r}, allowed are {LEVELS}")
    repeated = sorted(name for name, count in Counter(names).items() if count > 1)
    if repeated:
        raise SuperelementError(f"{where}: interface names {repeated} occur more than once")


def check_coordinates(element: Superelement, where: str) -> None:
    """Refuse coordinates that are out of order, repeated or at an unknown interface."""
    names = {node.name: None for node in element.interfaces}
    seen: set[tuple[str, str]] = set()
    modal_at: int | None = None
    if not element.coordinates:
        raise SuperelementError(f"{where}: has no coordinates; at least one is needed")
    for index, c in enumerate(element.coordinates):
        place = f"{where}: coordinate {index}"
        if c.kind == "modal":
            modal_at = index if modal_at is None else modal_at
            if c.component != "q" or c.interface or not (np.isfinite(c.frequency_hz)):
                raise SuperelementError(
                    f"{place} is modal and needs component 'q', no interface and a finite "
                    f"frequency; found {c}"
                )
            continue
        if c.kind != "interface" or c.component not in MOTIONS:
            raise SuperelementError(f"{place}: {c} is neither modal nor one of {MOTIONS}")
        if modal_at is not None:
            raise SuperelementError(
                f"{place} ({c.label}) follows modal coordinate {modal_at}; interface coordinates "
                "come first"
            )
        if c.interface not in names:
            raise SuperelementError(
                f"{place} names interface {c.interface!r}; the body has {list(names)}"
            )
        if (c.interface, c.component) in seen:
            raise SuperelementError(f"{place}: {c.label} occurs more than once")
        seen.add((c.interface, c.component))


def check_scalars(element: Superelement, where: str) -> None:
    """Refuse scalars out of range and short vectors whose lengths disagree."""
    checks = {
        "mass_kg": (np.isfinite(element.mass_kg) and element.mass_kg > 0, "a positive number"),
        "maximum_speed_rad_s": (element.maximum_speed_rad_s >= 0, "0 or more, or inf"),
        "full_dofs": (element.full_dofs >= 0, "0 or more"),
    }
    for name, (passed, allowed) in checks.items():
        if not passed:
            raise SuperelementError(
                f"{where}: {name} is {getattr(element, name)}, allowed is {allowed}"
            )
    errors, fixed = element.frequency_error_estimate, element.fixed_interface_frequencies_hz
    if errors.size not in (0, fixed.size):
        raise SuperelementError(
            f"{where}: frequency_error_estimate has {errors.size} entries, allowed is 0 or "
            f"{fixed.size}, one for each fixed-interface frequency"
        )
    for name in ("free_frequencies_hz", "fixed_interface_frequencies_hz"):
        if (getattr(element, name) < 0).any():
            raise SuperelementError(f"{where}: {name} has a negative frequency")
    _check_mass(element, where)


def _check_mass(element: Superelement, where: str) -> None:
    """Refuse what no body can have."""
    inertia = element.inertia_kg_m2
    largest = max(float(np.abs(inertia).max()), 1e-300)
    if (np.abs(inertia / largest - inertia.T / largest) > SYMMETRY_LIMIT).any():
        raise SuperelementError(f"{where}: inertia_kg_m2 is not symmetric: {inertia.tolist()}")
    principal = np.linalg.eigvalsh(inertia / largest)  # ascending
    if principal[0] < -_INERTIA_LIMIT or principal[2] > principal[:2].sum() + _INERTIA_LIMIT:
        raise SuperelementError(
            f"{where}: inertia_kg_m2 has the principal values {(largest * principal).tolist()}; "
            "in a body none is negative, and none above the sum of the others"
        )


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
