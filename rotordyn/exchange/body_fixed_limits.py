"""What files of a body in its own frame leave out, and the damping given to its modes."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.body_fixed import BodyFixedForm
from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.superelement import Superelement
from solidwhirl.rotordyn.superelement_checks import MOTIONS

_ELASTIC = {2: ("uz", "axial motion"), 5: ("rz", "torsion")}


def body_fixed_limits(element: Superelement, form: BodyFixedForm) -> tuple[str, ...]:
    """Say what of a body is lost in its form in the body's frame, whatever the file.

    Parameters
    ----------
    element
        The body.
    form
        What is written of it.

    Returns
    -------
    tuple of str
        Sentences.
    """
    sentences = [
        "Stiffening by spin about x and y, by acceleration and by interface forces is not known "
        "and is written as zero.",
        "Estimates of the error of the reduction are not written.",
    ]
    written, all_of_them = form.frequencies_hz.size, element.size - _rigid_motions(element)
    if written < all_of_them:
        sentences.append(
            f"{written} of {all_of_them} elastic modes are written, up to "
            f"{form.frequencies_hz[-1]:.6g} Hz; what the others give under load is lost."
        )
    for motion, (component, words) in _ELASTIC.items():
        if not element.rigid_body_present[motion]:
            sentences.append(
                f"The body has no {component} coordinates: in the file it is rigid in {words}."
            )
    sentences += _still_interfaces(element)
    if np.isfinite(element.maximum_speed_rad_s):
        sentences.append(
            f"The modes were made for speeds up to {element.maximum_speed_rad_s:.6g} rad/s, which "
            "the program that reads the file will not know."
        )
    return tuple(sentences)


def modal_damping_matrix(form: BodyFixedForm, modal_damping: float) -> FloatArray:
    """Return the damping matrix of modes with one damping ratio.

    Parameters
    ----------
    form
        The body.
    modal_damping
        Damping ratio of every mode, 0 to 1.

    Returns
    -------
    ndarray
        2 ζ ω on the diagonal, shape (m, m), 1/s.

    Raises
    ------
    SuperelementError
        If the ratio is out of its range.
    """
    if not 0.0 <= modal_damping <= 1.0:
        raise SuperelementError(f"modal_damping is {modal_damping}, allowed are 0 to 1")
    return np.diag(4.0 * np.pi * modal_damping * form.frequencies_hz)


def _still_interfaces(element: Superelement) -> list[str]:
    """Say at which interfaces motions are missing that the body has."""
    able = [motion for motion, has in zip(MOTIONS, element.rigid_body_present, strict=True) if has]
    places: dict[str, list[str]] = {}
    for node in element.interfaces:
        has = element.components_at(node.name)
        missing = ", ".join(motion for motion in able if motion not in has)
        places.setdefault(missing, []).append(repr(node.name))
    return [
        f"Interfaces without coordinates {missing}: {', '.join(names)}. The modes do not move them "
        "in these, and nothing may be attached that loads them so."
        for missing, names in places.items()
        if missing
    ]


def _rigid_motions(element: Superelement) -> int:
    """Return the number of rigid motions the body can make."""
    return int(np.count_nonzero(element.rigid_body_present))
