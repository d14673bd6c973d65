"""Error forms in a superelement file: one group for each part."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import h5py
import numpy as np

from solidwhirl.rotordyn.error_forms import BLOCKS, FORM_PARTS, ErrorForm
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.file_checks import SuperelementFile
from solidwhirl.rotordyn.file_format import put_numbers

GROUP = "error_forms"
_SCALARS = ("safety", "cutoff_rad_s")


def write_error_forms(file: h5py.File, forms: Sequence[ErrorForm]) -> None:
    """Write the forms of a body; no group is made where there are none.

    Parameters
    ----------
    file
        Open for writing.
    forms
        Each part once.
    """
    if not forms:
        return
    parts = file.create_group(GROUP)
    for form in forms:
        group = parts.create_group(form.part)
        group.attrs.update({name: np.float64(getattr(form, name)) for name in _SCALARS})
        put_numbers(group, "gram", form.gram, axes="block(K,M,G,K2) coordinate, the same")
        if form.stiffness_change is not None:
            put_numbers(group, "stiffness_change", form.stiffness_change)


def read_error_forms(file: SuperelementFile, n: int) -> tuple[ErrorForm, ...]:
    """Read the forms of a body with n coordinates.

    Parameters
    ----------
    file
        Open for reading.
    n
        Number of coordinates.

    Returns
    -------
    tuple of ErrorForm
        Empty for a file without them, as those of older versions.

    Raises
    ------
    SuperelementError
        If a part is unknown (leaving it out would understate the error), a group is a link, an
        attribute is missing, or shapes and numbers are not what a form needs.
    """
    if not file.has(GROUP):
        return ()
    parts = file.group(GROUP)
    return tuple(_read_form(file, part, n) for part in parts)


def _read_form(file: SuperelementFile, part: str, n: int) -> ErrorForm:
    place = f"{GROUP}/{part}"
    if part not in FORM_PARTS:
        raise file.error(place, f"is a part this program does not know; it knows {FORM_PARTS}")
    group = file.group(place)
    safety, cutoff = (
        _scalar(file, place, name, file.attribute(group, place, name)) for name in _SCALARS
    )
    try:
        return ErrorForm(
            part=part,
            gram=file.numbers(f"{place}/gram", (BLOCKS * n, BLOCKS * n)),
            stiffness_change=file.optional_numbers(f"{place}/stiffness_change", (n, n)),
            safety=safety,
            cutoff_rad_s=cutoff,
        )
    except SuperelementError as error:
        raise file.named(error) from error


def _scalar(file: SuperelementFile, place: str, name: str, value: Any) -> float:
    number = np.asarray("missing" if value is None else value)
    if number.shape != () or number.dtype.kind not in "fiu":
        raise file.error(place, f"has {name} {value!r}; a number is needed")
    return float(number)
