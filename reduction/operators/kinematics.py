"""What differs between the harmonic and the solid description of a spinning body.

Both describe the displacement in fixed components of the material that is at a place. All weak
forms (see `operators.forms`) are written once, on three ideas: the strain tensor, the
gradient columns ``[∂u/∂e_1, ∂u/∂e_2, ∂u/∂e_3]`` along three orthogonal directions, and the
derivative along the spin ``D u = ((e_z × x)·∇) u``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
import ufl
from dolfinx import fem

from solidwhirl.reduction.operators import compat
from solidwhirl.reduction.operators.cyclic import CyclicIndex
from solidwhirl.reduction.operators.joined import JoinedParts
from solidwhirl.rotordyn.core.arrays import FloatArray, Matrix

#: Rigid motions: translations and right-handed rotations about x, y, z through a point.
COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
# The second family with the amplitudes of a tilt +ry turns about -x.
_SECOND_FAMILY = {"ux": ("uy", 1.0), "ry": ("rx", -1.0)}


@dataclass(frozen=True, kw_only=True)
class Kinematics:
    """Strain, gradient and spin derivative of a displacement, as UFL."""

    dimension: int  #: 2 (meridian) or 3 (solid)
    #: Circumferential order n of the meridian, cyclic index h of a sector; None: the whole solid
    harmonic: int | None
    #: How many copies of the body's unknowns there are: 2 for n >= 1 (cos and sin family, which
    #: share every matrix and are coupled by the spin derivative), else 1
    families: int
    #: Factor of the volume element (r times the integral over θ; of a sector its copies)
    weight: Any
    #: Functions of u: (3, 3) UFL tensors
    strain: Callable[[Any], Any]
    gradient: Callable[[Any], Any]
    #: D u; on the meridian of two families, P u with D cos = -P sin, D sin = P cos
    spin: Callable[[Any], Any]
    #: By component (of the first family), the rigid motion of unit amplitude about the point (0, 0,
    #: z0): nodal values (m, 3) from node coordinates (m, 3) and z0; on the solid about any point
    #: (3,); complex on a sector
    rigid_motions: Mapping[str, Callable[[FloatArray, Any], Matrix]]
    #: First family's component to (component, sign) of the second family
    second_family: Mapping[str, tuple[str, float]]
    #: Body force per unit density and unit speed squared, r e_r, in the components of u
    centrifugal: Any
    cyclic: CyclicIndex | None = None  #: Of a sector, see `operators.cyclic`
    joined: JoinedParts | None = None  #: Of parts with sectors of different counts


def solid(domain: Any) -> Kinematics:
    """Kinematics of the three-dimensional solid.

    `domain`: mesh of dimension 3, rotation axis z.
    """
    x = ufl.SpatialCoordinate(domain)
    along_spin = ufl.as_vector((-x[1], x[0], 0.0 * x[0]))

    return Kinematics(
        dimension=3,
        harmonic=None,
        families=1,
        weight=compat.constant(domain, 1.0),
        strain=lambda u: ufl.sym(ufl.grad(u)),
        gradient=ufl.grad,
        spin=lambda u: ufl.dot(ufl.grad(u), along_spin),
        rigid_motions={c: partial(_solid_motion, k) for k, c in enumerate(COMPONENTS)},
        second_family={},
        centrifugal=ufl.as_vector((x[0], x[1], 0.0 * x[0])),
    )


def sector(domain: Any, cyclic: CyclicIndex, joined: JoinedParts | None = None) -> Kinematics:
    """Kinematics of one cyclic index on a sector of the solid.

    The amplitudes of index 1 are those of the meridian: u = Re[(q1 - i q2) Φ] with q1 and q2 of the
    first and the second family. Forms are of one part of Φ, see `operators.cyclic`. `joined`: parts
    whose sectors differ from that of the index, which is the first part's.
    """
    whole = solid(domain)
    motions: dict[str, Callable[[FloatArray, Any], Matrix]] = {}
    if cyclic.index == 0:
        # of half a sector, torsion is antisymmetric
        factor = 1j if cyclic.sector.mirrored else 1.0
        motions = {
            "uz": whole.rigid_motions["uz"],
            "rz": lambda x, z0: factor * whole.rigid_motions["rz"](x, z0),
        }
        if cyclic.symmetric:
            del motions["rz"]
    elif cyclic.index == 1:
        motions = {"ux": _turning_translation, "ry": _turning_tilt}
    return replace(
        whole,
        harmonic=cyclic.index,
        families=1 if cyclic.is_real else 2,
        weight=_weight(domain, cyclic, joined),
        rigid_motions=motions,
        second_family=_SECOND_FAMILY if cyclic.index == 1 else {},
        cyclic=cyclic,
        joined=joined,
    )


def _weight(domain: Any, cyclic: CyclicIndex, joined: JoinedParts | None) -> Any:
    """Factor of integrals over a sector, or over each part of a joined body."""
    if joined is None:
        return compat.constant(domain, cyclic.weight)
    own = np.array([replace(cyclic, sector=sector).weight for sector in joined.sectors])
    field = fem.Function(compat.scalar_space(domain, "DG", 0))
    field.x.array[:] = own[joined.cell_part]
    return field


def harmonic(domain: Any, order: int) -> Kinematics:
    """Kinematics of circumferential order n on the meridian (z, r).

    The amplitudes are (a, b, c) with, for the cos family, u_r = a cos nθ, u_θ = b sin nθ,
    u_z = c cos nθ, and for the sin family u_r = a sin nθ, u_θ = -b cos nθ, u_z = c sin nθ.
    For n = 0 they are u_r, u_θ, u_z themselves.

    `domain`: mesh of dimension 2, coordinates (z, r). `order`: n >= 0.
    """
    n = float(order)
    r = ufl.SpatialCoordinate(domain)[1]

    def strain(u: Any) -> Any:
        a, b, c = u[0], u[1], u[2]
        e_rt = 0.5 * (b.dx(1) - (b + n * a) / r)
        e_tz = 0.5 * (b.dx(0) - n * c / r)
        e_rz = 0.5 * (a.dx(0) + c.dx(1))
        e_tt = (n * b + a) / r
        return ufl.as_tensor(((a.dx(1), e_rt, e_rz), (e_rt, e_tt, e_tz), (e_rz, e_tz, c.dx(0))))

    def spin(u: Any) -> Any:
        if order == 0:
            return ufl.as_vector((-u[1], u[0], 0.0 * u[0]))
        return ufl.as_vector((n * u[0] + u[1], n * u[1] + u[0], n * u[2]))

    def gradient(u: Any) -> Any:
        around = spin(u) / r
        return ufl.as_tensor([(u[i].dx(1), around[i], u[i].dx(0)) for i in range(3)])

    motions: dict[str, Callable[[FloatArray, Any], FloatArray]] = {}
    if order == 0:
        motions = {"uz": _axial_motion, "rz": _torsional_motion}
    elif order == 1:
        motions = {"ux": _lateral_motion, "ry": _tilt_motion}
    return Kinematics(
        dimension=2,
        harmonic=order,
        families=1 if order == 0 else 2,
        weight=(2.0 if order == 0 else 1.0) * np.pi * r,
        strain=strain,
        gradient=gradient,
        spin=spin,
        rigid_motions=motions,
        second_family=_SECOND_FAMILY if order == 1 else {},
        centrifugal=ufl.as_vector((r, 0.0 * r, 0.0 * r)),
    )


def _solid_motion(index: int, x: FloatArray, z0: float | FloatArray) -> FloatArray:
    """Translation (index 0 to 2) or rotation (3 to 5) of a solid."""
    unit = np.eye(3)[index % 3]
    if index < 3:
        return np.broadcast_to(unit, x.shape).copy()
    about = np.array([0.0, 0.0, z0]) if np.ndim(z0) == 0 else z0
    return np.asarray(np.cross(unit, x - about))


def _turning_translation(x: FloatArray, z0: float) -> Matrix:
    """Index 1: ux in the first family, uy in the second."""
    return np.broadcast_to(np.array([1.0, 1.0j, 0.0]), x.shape)


def _turning_tilt(x: FloatArray, z0: float) -> Matrix:
    """Index 1: rotation about +y in the first family, about -x in the second."""
    z = x[:, 2] - z0
    return np.column_stack([z, 1j * z, -x[:, 0] - 1j * x[:, 1]])


def _lateral_motion(x: FloatArray, z0: float) -> FloatArray:
    """N = 1, cos family: translation along x."""
    return np.broadcast_to(np.array([1.0, -1.0, 0.0]), x.shape).copy()


def _tilt_motion(x: FloatArray, z0: float) -> FloatArray:
    """N = 1, cos family: rotation about +y."""
    z, r = x[:, 0] - z0, x[:, 1]
    return np.column_stack([z, -z, -r])


def _axial_motion(x: FloatArray, z0: float) -> FloatArray:
    """N = 0: translation along z."""
    return np.broadcast_to(np.array([0.0, 0.0, 1.0]), x.shape).copy()


def _torsional_motion(x: FloatArray, z0: float) -> FloatArray:
    """N = 0: rotation about z."""
    return np.column_stack([np.zeros(len(x)), x[:, 1], np.zeros(len(x))])
