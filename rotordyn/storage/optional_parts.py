"""Groups of a superelement file that a body may lack: moments, error forms, surface.

Files of older versions have none of them. Each reader returns nothing then, and raises
`SuperelementError` for a link, an unknown part, or shapes and numbers that do not fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import h5py
import numpy as np

from solidwhirl.rotordyn.storage.checked_reads import SuperelementFile
from solidwhirl.rotordyn.storage.format import put_numbers
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments
from solidwhirl.rotordyn.superelement.residual_energy import BLOCKS, FORM_PARTS, ErrorForm
from solidwhirl.rotordyn.superelement.surface import GROUP as SURFACE
from solidwhirl.rotordyn.superelement.surface import KINDS, Copies, Surface

_MOMENTS, _FORMS = "moments", "error_forms"
# Of a sector in a group of its own: readers of 1.3 know two kinds of surface.
_SECTOR = "sector_surface"
# Directions a, b of the second moments that are kept; [b, a, k, j] is [a, b, j, k].
_DIRECTIONS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
_IMAGINARY = "amplitudes_imaginary"
_SCALARS = ("safety", "cutoff_rad_s")


def write_moments(file: h5py.File, moments: MassMoments | None) -> None:
    """Write the mass moments of a body."""
    if moments is None:
        return
    group = file.create_group(_MOMENTS)
    put_numbers(group, "displacement", moments.displacement_kg, unit="kg", axes="a,coordinate")
    put_numbers(group, "first", moments.first_kg_m, unit="kg m", axes="place a,b,coordinate")
    blocks = np.stack([moments.second_kg[a, b] for a, b in _DIRECTIONS])
    put_numbers(
        group, "second", blocks, unit="kg", axes="ab(xx,yy,zz,xy,xz,yz),coordinate,coordinate"
    )


def read_moments(file: SuperelementFile, n: int) -> MassMoments | None:
    """Read the mass moments of a body with n coordinates."""
    if not file.has(_MOMENTS):
        return None
    file.group(_MOMENTS)
    blocks = file.numbers(f"{_MOMENTS}/second", (len(_DIRECTIONS), n, n))
    second = np.empty((3, 3, n, n))
    for (a, b), block in zip(_DIRECTIONS, blocks, strict=True):
        second[b, a] = block.T
        second[a, b] = block
    return MassMoments(
        displacement_kg=file.numbers(f"{_MOMENTS}/displacement", (3, n)),
        first_kg_m=file.numbers(f"{_MOMENTS}/first", (3, 3, n)),
        second_kg=second,
    )


def write_error_forms(file: h5py.File, forms: Sequence[ErrorForm]) -> None:
    """Write the error forms of a body, a group for each part."""
    if not forms:
        return
    parts = file.create_group(_FORMS)
    for form in forms:
        group = parts.create_group(form.part)
        group.attrs.update({name: np.float64(getattr(form, name)) for name in _SCALARS})
        put_numbers(group, "gram", form.gram, axes="block(K,M,G,K2) coordinate, the same")
        if form.stiffness_change is not None:
            put_numbers(group, "stiffness_change", form.stiffness_change)


def read_error_forms(file: SuperelementFile, n: int) -> tuple[ErrorForm, ...]:
    """Read the error forms of a body; leaving one out would understate the error."""
    if not file.has(_FORMS):
        return ()
    return tuple(_read_form(file, part, n) for part in file.group(_FORMS))


def _read_form(file: SuperelementFile, part: str, n: int) -> ErrorForm:
    place = f"{_FORMS}/{part}"
    if part not in FORM_PARTS:
        raise file.error(place, f"is a part this program does not know; it knows {FORM_PARTS}")
    group = file.group(place)
    safety, cutoff = (
        _scalar(file, place, name, file.attribute(group, place, name)) for name in _SCALARS
    )
    return ErrorForm(
        part=part,
        gram=file.numbers(f"{place}/gram", (BLOCKS * n, BLOCKS * n)),
        stiffness_change=file.optional_numbers(f"{place}/stiffness_change", (n, n)),
        safety=safety,
        cutoff_rad_s=cutoff,
    )


def _scalar(file: SuperelementFile, place: str, name: str, value: Any) -> float:
    number = np.asarray("missing" if value is None else value)
    if number.shape != () or number.dtype.kind not in "fiu":
        raise file.error(place, f"has {name} {value!r}; a number is needed")
    return float(number)


def write_surface(file: h5py.File, surface: Surface | None) -> None:
    """Write the surface of a body."""
    if surface is None:
        return
    copies = surface.copies
    group = file.create_group(SURFACE if copies is None else _SECTOR)
    group.attrs["kind"] = surface.kind
    put_numbers(group, "points", surface.points_m, unit="m", axes="point, x,y,z or z,r")
    put_numbers(group, "cells", surface.cells, axes="cell, point")
    kept = np.float64 if surface.kind == "meridian" else np.float32
    axes = "point, x,y,z or r,theta,z, term"
    put_numbers(group, "amplitudes", surface.amplitudes.real.astype(kept), axes=axes)
    if copies is not None:
        put_numbers(group, _IMAGINARY, surface.amplitudes.imag.astype(kept), axes=axes)
        whole = {"copies": np.int64(copies.count), "mirrored": np.int64(copies.mirrored)}
        group.attrs.update({**whole, "angle": copies.angle_rad})
    put_numbers(group, "coordinate", surface.coordinate)
    put_numbers(group, "order", surface.order)
    put_numbers(group, "family", surface.family, enum="0 cos, 1 sin")


def read_surface(file: SuperelementFile, n: int) -> Surface | None:
    """Read the surface of a body with n coordinates."""
    place = next((name for name in (SURFACE, _SECTOR) if file.has(name)), None)
    if place is None:
        return None
    allowed = KINDS[:2] if place == SURFACE else KINDS[2:]
    kind = file.attribute(file.group(place), place, "kind")
    if kind not in allowed:
        raise file.error(place, f"is of kind {kind!r}, allowed are {list(allowed)}")
    dimension = 2 if kind == "meridian" else 3
    points, cells, terms = (
        file.length(f"{place}/{name}") for name in ("points", "cells", "coordinate")
    )
    places = file.numbers(f"{place}/points", (points, dimension))
    amplitudes: Any = file.numbers(f"{place}/amplitudes", (points, 3, terms))
    copies = _read_copies(file, place) if kind == "sector" else None
    if copies is not None:
        amplitudes = amplitudes + 1j * file.numbers(f"{place}/{_IMAGINARY}", (points, 3, terms))
    return Surface(
        points_m=places,
        cells=file.numbers(f"{place}/cells", (cells, dimension)),  # type: ignore[arg-type]
        amplitudes=amplitudes,
        coordinate=np.array(file.wholes(f"{place}/coordinate", (terms,))),
        order=np.array(file.wholes(f"{place}/order", (terms,))),
        family=np.array(file.wholes(f"{place}/family", (terms,))),
        size=n,
        copies=copies,
    )


def _read_copies(file: SuperelementFile, place: str) -> Copies:
    group = file.group(place)
    count, mirrored = (
        file.whole_number(f"{place}: attribute {name!r}", file.attribute(group, place, name))
        for name in ("copies", "mirrored")
    )
    angle = _scalar(file, place, "angle", file.attribute(group, place, "angle"))
    return Copies(count=count, mirrored=bool(mirrored), angle_rad=angle)
