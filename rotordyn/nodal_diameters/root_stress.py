"""Modal stress at the roots of blades, from the equilibrium of each blade and from its elements.

The root section carries what the blade's inertia asks for: with a = -ω²u + 2iωΩ e_z×u - Ω²u⊥ and
the steady acceleration -Ω²x⊥, force ∫ρ a dV and moment ∫ρ [(x - x0)×a - (u - u0)×Ω²x⊥] dV about
its centre x0, which moves by u0. The normal stress that is linear over the section and balances
them, N/A + M y/I, is an integral of the mode: it converges as the mode does. The stress in the
elements at a sharp edge does not; it grows as they get smaller.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from solidwhirl.rotordyn.core.arrays import ComplexArray, FloatArray, Matrix, ReadOnlyArrays

# e_z × u = _TURN u
_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
_ACROSS = np.diag([1.0, 1.0, 0.0])
# Von Mises stress is √(σ·F σ) of xx, yy, zz, xy, yz, xz.
_VON_MISES = np.diag([1.5, 1.5, 1.5, 3.0, 3.0, 3.0])
_VON_MISES[:3, :3] -= 0.5


@dataclass(frozen=True, kw_only=True, eq=False)
class RootSection(ReadOnlyArrays):
    """Where a blade meets what carries it, as a plane section."""

    area_m2: float
    centre_m: FloatArray  #: (3,)
    axes: FloatArray  #: (3, 3) rows: two along the section, and its normal into the blade
    points_m: FloatArray  #: (p, 2) of the section along the first two axes, from its centre
    second_moments_m4: FloatArray  #: (2, 2) ∫ s sᵀ dA


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeRoot(ReadOnlyArrays):
    """One blade and its root in the coordinates of one cyclic index."""

    section: RootSection
    first_moment_kg_m: FloatArray  #: (3,) ∫ρ x dV of the blade
    #: Of every coordinate: ∫ρ u_i dV (3, n), ∫ρ u_i x_j dV (3, 3, n), mean of u on the root (3, n)
    momentum: Matrix
    moments: Matrix
    centre: Matrix
    #: (q, 6, n) xx, yy, zz, xy, yz, xz inside the blade's elements at the root
    stress_pa: Matrix


class RootStress(NamedTuple):
    """Amplitudes over one cycle of modes, (m,)."""

    nominal_pa: FloatArray  #: Of force and bending moment, largest on the section
    peak_pa: FloatArray  #: Von Mises, largest in the elements


def root_stress(
    root: BladeRoot, rates_rad_s: FloatArray, speed_rad_s: float, vectors: Matrix
) -> RootStress:
    """Return the stress at a root in modes φ e^{iωt} of a speed.

    `rates_rad_s`: (m,) ω. `vectors`: (n, m) φ.
    """
    normal = _section_normal_stress(root, rates_rad_s, speed_rad_s, vectors)
    peak = cycle_peak(root.stress_pa @ vectors, _VON_MISES)
    return RootStress(nominal_pa=np.abs(normal).max(axis=0), peak_pa=peak.max(axis=0, initial=0.0))


def _section_normal_stress(
    root: BladeRoot, rates: FloatArray, speed: float, vectors: Matrix
) -> ComplexArray:
    """Normal stress of the points of a section, (p, m)."""
    section = root.section
    # a = D u, for every mode
    inertia = (
        -(rates**2)[:, None, None] * np.eye(3)
        + (2j * rates * speed)[:, None, None] * _TURN
        - speed**2 * _ACROSS
    )
    momentum, moved = root.momentum @ vectors, root.centre @ vectors
    moments = np.tensordot(root.moments, vectors, axes=1)
    force = np.einsum("mij,jm->im", inertia, momentum)
    # ∫ρ a_i x_j, and of the steady acceleration with the displacement
    forces = np.einsum("mij,jkm->ikm", inertia, moments)
    moment = _cross(forces) - np.cross(section.centre_m, force, axis=0)
    steady = -(speed**2) * _ACROSS @ root.first_moment_kg_m
    moment += _cross(np.tensordot(-(speed**2) * _ACROSS, moments.transpose(1, 0, 2), axes=1))
    moment -= np.cross(moved, steady[:, None], axis=0)
    tension = -section.axes[2] @ force  # the root pulls the blade inward
    along, across, _ = section.axes @ moment
    # ∫ s σ dA = (M2, -M1), as the section of the blade looks inward
    slope = np.linalg.solve(section.second_moments_m4, np.array([across, -along]))
    return np.asarray(tension / section.area_m2 + section.points_m @ slope)


def _cross(products: ComplexArray) -> ComplexArray:
    """∫ x × a from ∫ a_i x_j, (3, 3, m) to (3, m)."""
    return np.array(
        [
            products[2, 1] - products[1, 2],
            products[0, 2] - products[2, 0],
            products[1, 0] - products[0, 1],
        ]
    )


def cycle_peak(amplitudes: Matrix, form: FloatArray | None = None) -> FloatArray:
    """Return the largest √(v·F v) of v = Re(a e^{iφ}) over the phase.

    `amplitudes`: a, (p, c, m); `form`: F, (c, c); None: the length of v. Returns (p, m).
    """
    shaped = amplitudes if form is None else np.einsum("cd,pdm->pcm", form, amplitudes)
    mean = (amplitudes.conj() * shaped).sum(axis=1).real
    turning = np.abs((amplitudes * shaped).sum(axis=1))
    return np.asarray(np.sqrt(np.maximum(0.5 * (mean + turning), 0.0)))
