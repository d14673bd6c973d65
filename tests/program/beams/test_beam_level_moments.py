"""Mass moments of the beam level: rigid motions, the matrices of the model, the harmonic level."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
import scipy.linalg as la

from solidwhirl.beams.body import beam_element_of, beam_variants
from solidwhirl.beams.error import VARIANTS

ALL = ("ux", "uy", "uz", "rx", "ry", "rz")
CROSS = np.zeros((3, 3, 3))
for k, d, a in itertools.permutations(range(3)):
    CROSS[a, k, d] = np.linalg.det(np.eye(3)[[k, d, a]])


def size_of(array):
    return np.abs(array).max()


@pytest.mark.parametrize("name", ["thick disk", "cone", "large step", "drum", "filleted rim"])
def test_moments_belong_to_the_matrices(beam_bodies, name):
    """The trace is M, and what the planes exchange in the body's frame is G + 2 M L."""
    body = beam_bodies[name.split()[-1] if name.startswith("filleted") else name]
    if name.startswith("filleted"):
        body = dataclasses.replace(body, fillet_radius_m=2e-3)
    element = beam_element_of(body, components=ALL)
    second, motions = element.moments.second_kg, element.rigid_body_modes
    root = np.sqrt(np.diag(element.mass))
    # rounding of plates much stiffer than shafts
    trace = second[0, 0] + second[1, 1] + second[2, 2] - element.mass
    assert size_of(trace / np.outer(root, root)) < 1e-12
    # the gyroscopic matrix is assembled from the inertia of sections and plates
    coriolis = element.gyroscopic + 2.0 * element.mass @ element.spin_generator
    change = coriolis - 2.0 * (second[1, 0] - second[0, 1])
    assert size_of(change / np.outer(root, root)) < 1e-12
    mass, z = element.mass_kg, element.center_of_gravity_m[2]
    expected = mass * np.hstack([np.eye(3), np.einsum("akd,d->ak", CROSS, [0.0, 0.0, z])])
    moments = element.moments
    np.testing.assert_allclose(moments.displacement_kg @ motions, expected, atol=1e-9 * mass)
    for k in range(3):
        simple = np.einsum("bjk,j->bk", second[k], motions[:, k])
        np.testing.assert_allclose(simple, moments.displacement_kg, atol=1e-9 * mass)
        turned = np.einsum("abjk,j->abk", second, motions[:, 3 + k])
        first = np.einsum("ad,dbj->abj", CROSS[:, k], moments.first_kg_m)
        np.testing.assert_allclose(turned, first, atol=1e-9 * mass)


def mode_numbers(element):
    """Moments of the first bending, axial and torsional free modes that no sign changes."""
    lateral = np.abs(element.spin_generator).any(axis=0)
    second, first = element.moments.second_kg, element.moments.first_kg_m
    modes = {}
    for kind, chosen in (("lateral", lateral), ("other", ~lateral)):
        at = np.flatnonzero(chosen)
        values, vectors = la.eigh(element.stiffness[np.ix_(at, at)], element.mass[np.ix_(at, at)])
        full = np.zeros((element.size, len(at)))
        full[at] = vectors
        modes[kind] = full[:, values > 1e4]  # above 16 Hz
    bending = modes["lateral"][:, :2]
    share = np.einsum("jm,jk,km->m", modes["other"], second[2, 2], modes["other"])
    axial = modes["other"][:, share > 0.5][:, :1]
    torsion = modes["other"][:, share < 0.5][:, :1]

    def of(a, b, left, right):
        return np.linalg.norm(left.T @ second[a, b] @ right)

    return np.array(
        [
            of(0, 0, bending, bending),
            of(2, 2, bending, bending),
            of(0, 2, bending, axial),
            of(2, 1, bending, torsion),
            of(1, 1, torsion, torsion),
            np.linalg.norm(first[2, 2] @ axial),
        ]
    )


@pytest.mark.solver
@pytest.mark.parametrize(
    # measured: 7e-4, 4e-2 (axial motion of the disk; 3e-3 without) and 7e-3, what beam theory errs
    ("name", "close"),
    [("uniform", 0.002), ("slender", 0.06), ("thin disk", 0.01)],
)
def test_moments_of_modes_are_those_of_the_harmonic_level(
    harmonic_element, beam_bodies, name, close
):
    body = beam_bodies[name]
    judge = harmonic_element(body, orders=(0, 1), components=ALL, modes=8)
    exact, found = mode_numbers(judge), mode_numbers(beam_element_of(body, components=ALL))
    np.testing.assert_allclose(found, exact, rtol=close, atol=1e-3 * close * exact.max())


def test_only_the_model_of_the_run_knows_its_moments(beam_bodies):
    """Variants tell frequencies; the one that only lacks an effect is the first model otherwise."""
    first, *others = beam_variants(beam_bodies["step"])
    alone = beam_element_of(beam_bodies["step"])
    np.testing.assert_array_equal(first.moments.second_kg, alone.moments.second_kg)
    known = [v.name for v, e in zip(VARIANTS[1:], others, strict=True) if e.moments]
    assert known == ["no centrifugal stiffness"]
