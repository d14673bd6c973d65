"""Numbers of modes, free bodies, and two equal units at the ends of one shaft."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import scipy.linalg
from builders_body import even, meshed, nearest_error, reduced, tube
from builders_more import dense, held_space, material, mirrored, operators_of, refusal
from reduced import reduced_to, sparse
from references_body import timoshenko_free_hz
from shapes import STEEL, plane, section

from solidwhirl.geometry import Body
from solidwhirl.meshing import MeshSize
from solidwhirl.reduction import ReductionWork
from solidwhirl.rotordyn import Superelement
from solidwhirl.rotordyn.superelement.free_body import rigid_centrifugal_energy

SPLIT = 1e-9
ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
SHAFT = {
    "harmonic": even(0.02),
    "solid": MeshSize(size_m=0.05, corner_size_m=0.05, around=4),
}
RING = tube(0.04, 0.03, 0.05, plane("end", 0.0))
FEW_UNKNOWNS = {
    "harmonic": even(0.02),
    "solid": MeshSize(size_m=0.06, corner_size_m=0.06, around=4, through_thickness=0.5),
}
DUMBBELL = {
    "harmonic": even(0.02),
    "solid": MeshSize(size_m=0.05, corner_size_m=0.05, around=8, through_thickness=0.5),
}


def _many_of_a_solid() -> float:
    """6 pairs of a solid: modes of dense eigenvalues that are not found, of order 1."""
    body, size = tube(0.2, 0.0, 0.02, plane("a", 0.0), plane("b", 0.2)), even(0.2, 4)
    request = {"components": ("ux", "uy", "rx", "ry"), "modes": 6}
    found = reduced(body, "solid", size, **request)[0].fixed_interface_frequencies_hz
    operators = operators_of(body, "solid", size, 1)
    held = held_space(operators)
    k, m = (held.T @ dense(a) @ held for a in (operators.stiffness, operators.mass))
    operators.release()
    values = scipy.linalg.eigh(k, m, eigvals_only=True, subset_by_index=[0, 3 * len(found) - 1])
    return nearest_error(np.sqrt(values) / (2.0 * np.pi), found)


def _free_beam(level: str) -> float:
    """A free body without interfaces against Timoshenko's beam, L/D = 20."""
    size = even(0.02) if level == "harmonic" else even(0.03, 8)
    element = reduced(tube(0.8, 0.0, 0.02), level, size, components=(), modes=2)[0]
    return abs(float(element.free_frequencies_hz[0]) / timoshenko_free_hz(0.8, 0.02, STEEL) - 1.0)


def _held_shaft(level: str, modes: int) -> Superelement:
    body = tube(0.5, 0.0, 0.02, plane("left", 0.05), plane("right", 0.45))
    return reduced(body, level, SHAFT[level], modes=modes)[0]


def _one_mode(level: str) -> float:
    """First free frequency with one mode against twelve; inf if there is not one pair."""
    few, many = _held_shaft(level, 1), _held_shaft(level, 12)
    if len(few.fixed_interface_frequencies_hz) != 2:
        return np.inf
    return float(few.free_frequencies_hz[0] / many.free_frequencies_hz[0] - 1.0)


def _cut_pairs() -> float:
    """Solid with all motions: fixed-interface modes that are lateral and do not come in pairs.

    Which ones are lateral is known from a solution for lateral motion alone.
    """
    body, alone = tube(0.5, 0.0, 0.02, plane("end", 0.1)), 0
    lateral = reduced(body, "solid", SHAFT["solid"], modes=8)[0].fixed_interface_frequencies_hz
    for modes in (1, 2, 3, 4):
        request = {"orders": (0, 1), "components": ALL, "modes": modes}
        element = reduced(body, "solid", SHAFT["solid"], **request)[0]
        held = element.fixed_interface_frequencies_hz
        pairs = np.array([np.sum(np.abs(held / f - 1.0) < SPLIT) for f in held])
        known = np.array([np.abs(lateral / f - 1.0).min() < 1e-6 for f in held])
        alone += int(np.sum(pairs[known] != 2)) + int(len(held) < 2 * modes)
    return float(alone)


@lru_cache(maxsize=2)
def _many(modes: int) -> Superelement:
    return reduced(tube(0.2, 0.03, 0.05), "harmonic", even(0.01), components=(), modes=modes)[0]


def _five_hundred_all() -> float:
    """All 500 modes against the eigenvalues of the dense matrices of the same mesh."""
    operators = operators_of(tube(0.2, 0.03, 0.05), "harmonic", even(0.01), 1)
    k, m = dense(operators.stiffness), dense(operators.mass)
    operators.release()
    exact = scipy.linalg.eigh(k, m, eigvals_only=True)[2:502]
    found = _many(500).fixed_interface_frequencies_hz[::2]
    if len(found) < 500:
        return np.inf
    return float(np.abs(2.0 * np.pi * found[:500] / np.sqrt(exact) - 1.0).max())


def _not_refused(level: str) -> float:
    operators = operators_of(RING, level, FEW_UNKNOWNS[level], 1)
    space = held_space(operators).shape[1]
    operators.release()
    # of both levels an unknown stands for both modes of a pair
    asked = (space + 1, space + 2, 2 * space, 10 * space, 10**9)
    return float(
        sum(
            not refusal(lambda n=n: reduced(RING, level, FEW_UNKNOWNS[level], modes=n))
            for n in asked
        )
    )


def _stated_number() -> float:
    """Whether the number of modes that a refusal allows is refused as well."""
    text = refusal(lambda: reduced(RING, "harmonic", FEW_UNKNOWNS["harmonic"], modes=10**6))
    allowed = int(text.split("can have ")[1].split()[0])
    request = {"modes": allowed}
    return float(
        bool(refusal(lambda: reduced(RING, "harmonic", FEW_UNKNOWNS["harmonic"], **request)))
    )


@lru_cache(maxsize=8)
def _spinning(level: str, planes: int) -> Superelement:
    body = tube(0.5, 0.01, 0.02, *[plane("only", 0.1)][:planes])
    spin = {"maximum_speed_rad_s": 1000.0, "centrifugal": True, "gyroscopic": True}
    return reduced(body, level, SHAFT[level], **spin)[0]


def _rigid_energy(level: str) -> float:
    """Largest over a body without interface and with one; inf if a rigid motion is missing."""
    elements = [_spinning(level, planes) for planes in (0, 1)]
    if any(np.count_nonzero(e.rigid_body_present) != 4 for e in elements):
        return np.inf
    return max(rigid_centrifugal_energy(element) for element in elements)


def _rigid_force(level: str) -> float:
    """|K R| on the mesh over what each entry of K does alone."""
    operators = operators_of(tube(0.5, 0.01, 0.02), level, SHAFT[level], 1)
    k = sparse(operators.stiffness)
    motions = np.column_stack(list(operators.rigid_motions.values()))
    operators.release()
    return float(np.max(np.abs(k @ motions).max(axis=0) / (abs(k) @ np.abs(motions)).max(axis=0)))


@lru_cache(maxsize=16)
def _dumbbell(level: str, heavier: float, modes: int) -> tuple[Superelement, ReductionWork]:
    """Two halves that a rigid cross-section in the middle parts; the left one is heavier."""
    other = material(STEEL.density_kg_per_m3 * (1.0 + heavier), STEEL.youngs_modulus_pa)
    right = (section("s", 0.0, 0.2, 0.0, 0.01, STEEL), section("d", 0.15, 0.2, 0.01, 0.06, STEEL))
    left = (section("t", -0.2, 0.0, 0.0, 0.01, other), section("e", -0.2, -0.15, 0.01, 0.06, other))
    middle = (plane("middle", 0.0, "rigid"),)
    half = Body(name="dumbbell", sections=right, interfaces=middle)
    mesh = mirrored(meshed(half, level, DUMBBELL[level]), other)
    whole = Body(name="dumbbell", sections=right + left, interfaces=middle)
    request = {"components": ("ux", "uy", "rx", "ry"), "modes": modes}
    return reduced_to(whole, level, mesh=mesh, **request)


def _orthogonality(level: str) -> float:
    return float(_dumbbell(level, 2e-8, 3)[1].orthogonality_error)


def _split_error(level: str) -> float:
    """Split of two pairs that differ by 1e-8 against ω ∝ 1/√ρ, in parts of the frequency."""
    heavier = 2e-8
    f = _dumbbell(level, heavier, 2)[0].fixed_interface_frequencies_hz[:4]
    ratios = f[2:, None] / f[None, :2] / np.sqrt(1.0 + heavier) - 1.0
    return float(np.abs(ratios).max())


def _wrong_numbers(level: str) -> float:
    """Modes that a request of 1, 2 or 3 pairs gets too many or too few: clusters of two pairs."""
    wrong = 0
    for heavier, modes, expected in ((0.0, 2, 4), (2e-8, 1, 4), (2e-8, 3, 8)):
        found = _dumbbell(level, heavier, modes)[0].fixed_interface_frequencies_hz
        wrong += abs(len(found) - expected)
    return float(wrong)


def _failed_checks(level: str) -> float:
    checks = [c for eps in (0.0, 2e-8, 2e-6) for c in _dumbbell(level, eps, 2)[1].checks]
    return float(sum(c.passed is False for c in checks))
