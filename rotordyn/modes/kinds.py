"""Kinds of motion: lateral, torsional, axial, disk or coupled, by shares of the kinetic energy.

In an undamped system the work of the elastic forces has the same shares, as φ_fᴴKφ = ω²φ_fᴴMφ for
the part φ_f of a mode φ in any coordinates.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import (
    BoolArray,
    ComplexArray,
    FloatArray,
    IntArray,
    StringArray,
)
from solidwhirl.rotordyn.superelement.families import FAMILIES, family_form

if TYPE_CHECKING:  # words of kinds are told where nothing is assembled
    from solidwhirl.rotordyn.assembly.coordinates import Placed

# A mode of one family has this share of the energy in it. By Rayleigh's quotient a model with that
# family alone, all others held, finds its frequency within about half of the rest: 5 %.
_PURE = 0.9
_LATERAL, _TORSIONAL = FAMILIES.index("lateral"), FAMILIES.index("torsional")
# Shares that are told.
_TOLD = 0.005


def energy_shares(placed: Placed, shapes: FloatArray | ComplexArray) -> FloatArray:
    """Return the share of each family in the kinetic energy of modes.

    Of the motion against the inertial frame, without the spin, as mean over a period. `placed`: the
    system, or one in axes that turn. `shapes`: in its independent coordinates, shape (n, m).
    Returns shape (m, 4), 0 to 1, in the order of `FAMILIES`; the sum over these is 1.

    Where the inertia of a body couples families, as an eccentric one does, each has half of what is
    in both. Motion without any mass counts as lateral.
    """
    return shares_of(family_energy(placed, shapes))


def family_energy(placed: Placed, shapes: FloatArray | ComplexArray) -> FloatArray:
    """Return φ_fᴴMφ of each family, shape (m, 4); arguments as of `energy_shares`."""
    energy = np.zeros((shapes.shape[1], len(FAMILIES)))
    for part in _parts(placed):
        motion = part.rows @ shapes[part.columns]
        energy += (motion.conj() * (part.mass @ motion)).real.T @ part.weights
    return energy


def shares_of(energy: FloatArray) -> FloatArray:
    """Return shares of energies of families, shape (..., 4)."""
    energy = np.maximum(energy, 0.0)
    energy[energy.sum(axis=-1) == 0.0, _LATERAL] = 1.0
    return np.asarray(energy / energy.sum(axis=-1, keepdims=True))


class _BodyPart(NamedTuple):
    """Independent coordinates that move a body, those of its `FamilyForm` from them, that form."""

    columns: IntArray
    rows: FloatArray
    mass: FloatArray
    weights: FloatArray


# Wanted at every speed of a diagram, and the same for all of them.
@lru_cache(maxsize=4)
def _parts(placed: Placed) -> tuple[_BodyPart, ...]:
    found = []
    for name, rotor in placed.system.rotors.items():
        rows = placed.transformation[placed.body_slices[name]]
        columns = np.flatnonzero(rows.any(axis=0))
        form = family_form(rotor.element)
        own = np.linalg.solve(form.basis, rows[:, columns])
        found.append(_BodyPart(columns, own, form.mass, form.weights))
    return tuple(found)


def kinds(shares: FloatArray) -> StringArray:
    """Return the kind of modes: one of `FAMILIES` with 0.9 of the energy, else "coupled".

    `shares`: of `energy_shares`, shape (..., 4), nan where there is no mode. Returns shape (...),
    empty there.
    """
    named = np.array([*FAMILIES, "coupled", ""])
    at = np.where(shares.max(axis=-1) >= _PURE, shares.argmax(axis=-1), len(FAMILIES))
    return np.asarray(named[np.where(np.isnan(shares).any(axis=-1), len(FAMILIES) + 1, at)])


def moves_laterally(shares: FloatArray) -> BoolArray:
    """Tell which modes are lateral, or coupled with lateral motion: what unbalance acts on.

    `shares`: as for `kinds`. Returns shape (...).
    """
    return np.asarray(1.0 - shares[..., _LATERAL] < _PURE)


def moves_torsionally(shares: FloatArray) -> BoolArray:
    """Tell which modes are torsional, or coupled with torsion; `shares`: as for `kinds`."""
    return np.asarray(1.0 - shares[..., _TORSIONAL] < _PURE)


def is_mostly_lateral(shares: FloatArray) -> BoolArray:
    """Tell which modes have most of their energy in lateral motion; `shares`: as for `kinds`."""
    return np.asarray(shares[..., _LATERAL] > 0.5)


def kind_words(shares: FloatArray) -> str:
    """Return the kind of one mode and what of other kinds is in it; `shares`: (4,)."""
    kind = str(kinds(shares))
    told = [
        f"{100.0 * shares[k]:.0f} % {FAMILIES[k]}"
        for k in np.argsort(-shares, kind="stable")
        if shares[k] >= _TOLD and FAMILIES[k] != kind
    ]
    return f"{kind} ({', '.join(told)})" if told else kind


def motion_words(whirl: str, shares: FloatArray) -> str:
    """Return how one mode moves: its whirl, or its kind; both where it is coupled.

    `whirl`: of `whirl.whirl_direction`; `shares`: (4,).
    """
    if kinds(shares) != "coupled":
        return whirl
    return kind_words(shares) if whirl == "coupled" else f"{whirl}, {kind_words(shares)}"


def shares_document(shares: FloatArray) -> dict[str, Any]:
    """Return shares by family as plain data, numbers or lists; `shares`: (..., 4)."""
    return {family: shares[..., k].tolist() for k, family in enumerate(FAMILIES)}


def shares_in(document: Mapping[str, float]) -> FloatArray:
    """Return the shares of `shares_document` as an array."""
    return np.array([document[family] for family in FAMILIES])
