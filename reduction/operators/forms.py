"""Weak forms of a spinning elastic body, written once for the harmonic and the solid level.

    M ü + Ω G u̇ + (K + Ω² (Kσ - S)) u = f

in the inertial frame (Hamilton's principle with the velocity v = Ω e_z×x + ∂u/∂t + Ω D u). On the
solid all but the stiffness may be given one component of u alone, see `solid_matrices`.

How much a field changes in a turn about the axis is J u = e_z × u - D u. On a field of
circumferential order n, J² = -n²; the Rayleigh quotient of ∫ ρ Jv·Ju tells the order of a
solid's modes.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.kinematics import Kinematics
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray


@dataclass(frozen=True, kw_only=True)
class Medium:
    """Material as cell-wise constant fields on the mesh."""

    density: Any  #: kg/m³
    first_lame: Any
    second_lame: Any
    #: (k, 4) x, y, z [m] of nodes with a point mass on them, and that [kg]
    point_masses: FloatArray = field(default_factory=lambda: np.empty((0, 4)))


def medium(domain: Any, material_tags: Any, materials: tuple[Any, ...]) -> Medium:
    """Fields of density and Lamé constants from the material number of every cell."""
    space = compat.scalar_space(domain, "DG", 0)
    fields = []
    for values in (
        [m.density_kg_per_m3 for m in materials],
        [
            m.youngs_modulus_pa
            * m.poissons_ratio
            / ((1.0 + m.poissons_ratio) * (1.0 - 2.0 * m.poissons_ratio))
            for m in materials
        ],
        [m.youngs_modulus_pa / (2.0 * (1.0 + m.poissons_ratio)) for m in materials],
    ):
        field = fem.Function(space)
        local = np.zeros(len(field.x.array))
        local[material_tags.indices] = np.array(values)[material_tags.values]
        field.x.array[:] = local
        field.x.scatter_forward()
        fields.append(field)
    return Medium(density=fields[0], first_lame=fields[1], second_lame=fields[2])


def measure(domain: Any, kinematics: Kinematics, degree: int) -> Any:
    """Volume measure of all forms, for elements of a degree.

    One quadrature for all: Kσ and S cancel for a rigid tilt only if they share it. The terms in
    1/r of the meridian are no polynomials and get two degrees more.
    """
    exact = 2 * degree if kinematics.dimension == 3 else 2 * degree + 2
    return ufl.Measure("dx", domain=domain, metadata={"quadrature_degree": exact})


def stress(kinematics: Kinematics, matter: Medium, u: Any) -> Any:
    """Cauchy stress of a displacement, isotropic linear elasticity (UFL tensor) [Pa]."""
    strain = kinematics.strain(u)
    return matter.first_lame * ufl.tr(strain) * ufl.Identity(3) + 2.0 * matter.second_lame * strain


def mass_form(kin: Kinematics, matter: Medium, u: Any, v: Any, dx: Any) -> Any:
    """M: ∫ ρ v·u."""
    return matter.density * ufl.inner(u, v) * kin.weight * dx


def stiffness_form(kin: Kinematics, matter: Medium, u: Any, v: Any, dx: Any) -> Any:
    """K: ∫ ε(v):C:ε(u)."""
    return ufl.inner(stress(kin, matter, u), kin.strain(v)) * kin.weight * dx


def gyroscopic_form(kin: Kinematics, matter: Medium, u: Any, v: Any, dx: Any) -> Any:
    """Return G for one family (skew), or N of G = [[0, 2N], [-2N, 0]] for two (symmetric).

    For one family the skew half ∫ ρ (v·Du - u·Dv) is taken, which equals 2 ∫ ρ v·Du on an exact
    body of revolution and stays exactly skew on a mesh of one. (Solids: `solid_matrices`.)
    """
    weight = matter.density * kin.weight
    if kin.families == 2:
        return weight * ufl.inner(kin.spin(u), v) * dx
    return weight * (ufl.inner(kin.spin(u), v) - ufl.inner(u, kin.spin(v))) * dx


def spin_form(kin: Kinematics, matter: Medium, u: Any, v: Any, dx: Any) -> Any:
    """∫ ρ v·Du of a solid."""
    return matter.density * ufl.inner(kin.spin(u), v) * kin.weight * dx


def softening_form(kin: Kinematics, matter: Medium, u: Any, v: Any, dx: Any) -> Any:
    """S: ∫ ρ Dv·Du (convective, centripetal softening at unit speed)."""
    return matter.density * ufl.inner(kin.spin(u), kin.spin(v)) * kin.weight * dx


def stiffening_form(kin: Kinematics, prestress: Any, u: Any, v: Any, dx: Any) -> Any:
    """Kσ: ∫ σ0:(∇uᵀ∇v), geometric stiffness of the stress at unit speed."""
    return ufl.inner(ufl.dot(kin.gradient(u), prestress), kin.gradient(v)) * kin.weight * dx


def centrifugal_form(kin: Kinematics, matter: Medium, v: Any, dx: Any) -> Any:
    """Load at unit speed: ∫ ρ r e_r·v."""
    return matter.density * ufl.inner(kin.centrifugal, v) * kin.weight * dx


def at_nodes(space: Any, kin: Kinematics, matter: Medium) -> tuple[IntArray, FloatArray]:
    """Return the nodes of this rank that carry point masses, and how much [kg], as forms weigh it.

    A mass is on the nearest node of the space, or in equal parts on those that are as near.
    """
    nodes, masses = [np.empty(0, dtype=np.int64)], [np.empty(0)]
    if len(matter.point_masses):
        comm, count = space.mesh.comm, space.dofmap.index_map.size_local
        places = space.tabulate_dof_coordinates()[:count]
        for *place, mass in matter.point_masses:
            away = np.linalg.norm(places - np.array(place), axis=1)
            nearest = min(comm.allgather(float(away.min(initial=np.inf))))
            size = max(comm.allgather(float(np.abs(places).max(initial=0.0))))
            own = np.flatnonzero(away <= nearest + 1e-9 * size)
            share = float(kin.weight.value) * mass / sum(comm.allgather(len(own)))
            nodes.append(own)
            masses.append(np.full(len(own), share))
    return np.concatenate(nodes), np.concatenate(masses)
