"""Displacement and stress of the solid from the coordinates of its superelement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import basix
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from numpy.typing import NDArray

from solidwhirl.meshing import Sector
from solidwhirl.reduction.operators import compat, forms, kinematics
from solidwhirl.reduction.operators.joints.press_fits import added_matrices
from solidwhirl.reduction.recovery.fields import BodyFields, OrderFields
from solidwhirl.reduction.recovery.sectors import (
    COLUMN,
    ROW,
    Pair,
    SharedPoints,
    mirrored,
    pair_of,
    shared_points,
)
from solidwhirl.reduction.solvers.vectors import diagonal, energies
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray
from solidwhirl.rotordyn.superelement.surface import angles

# Nodes of a mirrored tetrahedron, so that it is not turned inside out.
_MIRRORED_CELL = [0, 2, 1, 3, 5, 4, 6, 7, 9, 8]
# Displacement (p, 3), stress (p, 6) and energy of one field.
Sample = tuple[NDArray[Any], NDArray[Any], float]


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldPoints:
    """Nodes of the mesh, once for each material that meets there.

    Of half a sector the nodes of its mirror image follow, so that they are of a sector.
    """

    points_m: FloatArray  #: (p, 2) z, r or (p, 3) x, y, z
    cells: IntArray  #: (c, 6) or (c, 10) points of the second-order cells, dolfinx's order
    #: (c,) and (p,) numbers of materials
    cell_material: IntArray
    point_material: IntArray
    #: Sectors that make the solid, copy k turned by 2πk/copies about z and the angle of the first;
    #: 1 of a whole solid and of a meridian
    copies: int
    angle_rad: float

    def theta_rad(self, half_planes: int) -> FloatArray:
        """Angles of the half planes of a meridian, or of the copies of a sector."""
        flat = self.points_m.shape[1] == 2
        return self.angle_rad + angles(half_planes if flat else self.copies)


@dataclass(frozen=True, kw_only=True, eq=False)
class FieldTerm:
    """Displacement and stress of one order and family."""

    #: Circumferential order and family of a meridian, as in `rotordyn.superelement.Surface`. Of a
    #: sector cyclic index h, and the factor of the field at copy k, which is turned by kα: cos hkα
    #: (family 0) or sin hkα (1). Of a whole solid 0 and 0.
    order: int
    family: int
    #: (p, 3) amplitudes along r, θ, z, or along x, y, z; real or complex
    displacement_m: NDArray[Any]
    #: (p, 6) rr, θθ, zz, rθ, θz, rz, or xx, yy, zz, xy, yz, xz. The components rθ and θz go with
    #: the factor of u_θ, the others with that of u_r.
    stress_pa: NDArray[Any]


@dataclass(frozen=True, kw_only=True, eq=False)
class RecoveredFields:
    """Fields of one body in one state."""

    points: FieldPoints
    terms: tuple[FieldTerm, ...]
    steady: FieldTerm | None  #: Of the centrifugal load; None where it was not computed
    #: ½ ∫ σ:ε* of the state's own displacement, and what joints between sections add
    strain_energy_j: float
    rounding_j: float  #: What rounding may make of the energy of stiff springs


class StressRecovery:
    """Recover states of one body, one after the other.

    In every element the stress is taken at the points of the quadrature that is exact to twice the
    degree of the strain (for second order these are the points of Barlow 1976, Int. J. Numer.
    Methods Eng. 10, where it is more accurate than elsewhere), fitted by a polynomial of the
    strain's degree, and this is evaluated at the nodes: they are extrapolated. At a node the mean
    over the elements of one material is taken, weighted by their size; materials are kept apart,
    as the stress jumps between them.
    """

    def __init__(self, fields: BodyFields) -> None:
        self._fields = fields
        first = fields.orders[0]
        self.points = _field_points(first, fields)
        self._samplers = [_Sampler(order, self.points) for order in fields.orders]
        self._joints = [_of_joints(order) for order in fields.orders]
        self._sector = _sector_of(first)
        self._shared: SharedPoints | None = None
        if self._sector is not None:
            self._shared, self.points = _of_sector(self.points, self._samplers[0], self._sector)
        self._steady: FieldTerm | None = None

    @property
    def is_averaged(self) -> bool:
        """As of the fields."""
        return self._fields.is_averaged

    @property
    def size(self) -> int:
        """Number of coordinates of the superelement."""
        return sum(len(order.rows) for order in self._fields.orders)

    @property
    def material_names(self) -> tuple[str, ...]:
        """Names of the materials by number."""
        return tuple(material.name for material in self._fields.materials)

    def recover(self, motion: NDArray[Any], speed_rad_s: float) -> RecoveredFields:
        """Return the fields of a state.

        `motion`: coordinates of the superelement, real, or complex amplitudes, shape (n,).
        """
        q = self._fields.own_motion(np.asarray(motion))
        terms: list[FieldTerm] = []
        energy, rounding = 0.0, 0.0
        each = zip(self._fields.orders, self._samplers, self._joints, strict=True)
        for order, sampler, joints in each:
            moved = [
                [part @ own for part in _parts(order.values, self._sector)]
                for own in order.family_amplitudes(q)
            ]
            sampled = [[sampler.complex_sample(part) for part in parts] for parts in moved]
            energy += sum(stored for parts in sampled for _, _, stored in parts)
            if joints is not None:
                fields = [part for parts in moved for part in parts]
                block = np.column_stack([*np.real(fields), *np.imag(fields)])
                energy += 0.5 * float(energies(joints, block, MPI.COMM_SELF).sum())
                cancelled = np.abs(diagonal(joints, block)) @ block**2
                rounding += float(np.finfo(float).eps * cancelled.sum())
            terms += self._terms(order.harmonic or 0, sampled)
        return RecoveredFields(
            points=self.points,
            terms=tuple(terms),
            steady=self._centrifugal(speed_rad_s),
            strain_energy_j=energy,
            rounding_j=rounding,
        )

    def _terms(self, order: int, sampled: Sequence[Sequence[Sample]]) -> list[FieldTerm]:
        """Fields of one order from the samples of its families; those of zeros are left out."""
        if self._sector is None:
            pairs: Any = [(u, s) for ((u, s, _),) in sampled]
        else:
            moved, stress = (
                self._pair([(first[k], second[k]) for first, second in sampled], order)  # type: ignore[misc]
                for k in (0, 1)
            )
            pairs = [*zip(moved, stress, strict=True)]
        return [
            FieldTerm(order=order, family=family, displacement_m=u, stress_pa=s)
            for family, (u, s) in enumerate(pairs)
            if np.abs(u).any()
        ]

    def _pair(self, parts: Sequence[Pair], index: int) -> Pair:
        """Field of a sector from those of its families on the mesh; stress is made one."""
        assert self._sector is not None and self._shared is not None
        pair = pair_of(parts, self._sector, index)
        return pair if pair[0].shape[1] == 3 else self._shared.mean(pair, index)

    def _centrifugal(self, speed_rad_s: float) -> FieldTerm | None:
        """Displacement and stress of the free spinning body."""
        given = self._fields.orders[0]
        field = given.ingredients.centrifugal_field
        if field is None:
            return None
        if self._steady is None:
            kin = given.ingredients.kinematics
            sampler = self._samplers[0]
            if kin.dimension == 2 and given.harmonic:
                around = kinematics.harmonic(given.space.mesh, 0)
                sampler = _Sampler(given, self.points, around)
            values = compat.owned_values(field).copy()
            parts = [sampler.sample(part) for part in _parts(values, self._sector)]
            (self._steady,) = self._terms(0, [parts])
        square = speed_rad_s**2
        return replace(
            self._steady,
            displacement_m=square * self._steady.displacement_m,
            stress_pa=square * self._steady.stress_pa,
        )


def _of_joints(order: OrderFields) -> Any:
    """Stiffness of all of u that joints between sections add, PETSc; None without joints."""
    given = order.ingredients
    joints = given.joints
    added = added_matrices(order.space, given.kinematics, given.matter, joints.layer, joints.fit)
    return added.get("stiffness")


def _sector_of(order: OrderFields) -> Sector | None:
    cyclic = order.ingredients.kinematics.cyclic
    return None if cyclic is None else cyclic.sector


def _parts(values: NDArray[Any], sector: Sector | None) -> tuple[NDArray[Any], ...]:
    """Fields Φ1 and Φ2 of a sector."""
    return (values,) if sector is None else (values.real, values.imag)


def _of_sector(
    points: FieldPoints, sampler: _Sampler, sector: Sector
) -> tuple[SharedPoints, FieldPoints]:
    """Points of the whole sector from those of its mesh, and what its copies share."""
    weight, count = sampler.sizes, len(points.points_m)
    whole = replace(points, copies=sector.count, angle_rad=sector.angle_rad)
    if sector.mirrored:
        weight = np.tile(weight, 2)
        whole = FieldPoints(
            points_m=mirrored(points.points_m),
            cells=np.concatenate([points.cells, points.cells[:, _MIRRORED_CELL] + count]),
            cell_material=np.tile(points.cell_material, 2),
            point_material=np.tile(points.point_material, 2),
            copies=sector.count,
            angle_rad=sector.angle_rad,
        )
    key = np.column_stack([points.points_m, points.point_material])
    _, place, several = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    apart = np.tile(several[place.ravel()] > 1, len(weight) // count)
    shared = shared_points(whole.points_m, whole.point_material, weight, sector.count, apart)
    return shared, whole


class _Sampler:
    """Displacement, stress and energy of fields of one space at the points of a body."""

    def __init__(
        self, given: OrderFields, points: FieldPoints, around: kinematics.Kinematics | None = None
    ) -> None:
        kin = around or given.ingredients.kinematics
        matter, space = given.ingredients.matter, given.space
        degree = compat.polynomial_degree(space)
        corners = 3 if points.cells.shape[1] == 6 else 4
        kind = basix.CellType.triangle if corners == 3 else basix.CellType.tetrahedron
        at, weights = basix.make_quadrature(kind, 2 * (degree - 1))
        nodes = compat.geometry_points(corners - 1)
        self._field, self._points, self._domain = fem.Function(space), points, space.mesh
        stress = forms.stress(kin, matter, self._field)
        self._stress = compat.expression(stress, at)
        self._outward = _fit(at, weights, nodes, degree - 1)
        density = 0.5 * ufl.inner(stress, kin.strain(self._field)) * kin.weight
        self._energy = compat.compiled(density * forms.measure(self._domain, kin, degree))
        lagrange = basix.LagrangeVariant.gll_warped
        element = basix.create_element(basix.ElementFamily.P, kind, degree, lagrange)
        self._shapes = element.tabulate(0, nodes)[0].reshape(len(nodes), -1)
        self._unknowns = compat.cell_unknowns(space).reshape(len(points.cells), -1)
        size = np.repeat(_cell_sizes(points)[:, None], len(nodes), axis=1)
        self.sizes = self._sum(size)
        self._weights = (size / self.sizes[points.cells]).ravel()

    def sample(self, values: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Displacement (p, 3), stress (p, 6) and energy of a real field."""
        count, nodes = len(self._points.cells), len(self._points.points_m)
        if not values.any():
            return np.zeros((nodes, 3)), np.zeros((nodes, 6)), 0.0
        compat.owned_values(self._field)[:] = values
        self._field.x.scatter_forward()
        own = values.reshape(-1, 3)[self._unknowns]
        moved = np.empty((nodes, 3))
        moved[self._points.cells] = np.einsum("nd,cdi->cni", self._shapes, own)
        raw = compat.evaluated(self._stress, self._domain).reshape(count, -1, 3, 3)
        inside = raw[:, :, ROW, COLUMN]
        at_nodes = np.einsum("nq,cqi->cni", self._outward, inside).reshape(-1, 6)
        mean = [self._sum(self._weights * at_nodes[:, i]) for i in range(6)]
        return moved, np.stack(mean, axis=1), compat.assembled_number(self._energy)

    def complex_sample(self, values: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any], float]:
        """The same of a field that may be complex; the energy is that of both parts."""
        moved, stress, energy = self.sample(np.ascontiguousarray(values.real))
        if not np.iscomplexobj(values):
            return moved, stress, energy
        also, more, other = self.sample(np.ascontiguousarray(values.imag))
        return moved + 1j * also, stress + 1j * more, energy + other

    def _sum(self, values: FloatArray) -> FloatArray:
        """Sum over the elements at every point."""
        flat = self._points.cells.ravel()
        return np.bincount(flat, values.ravel(), len(self._points.points_m)).astype(float)


def _field_points(given: OrderFields, fields: BodyFields) -> FieldPoints:
    nodes, table = compat.curved_cells(given.space.mesh)
    material = _materials(given, fields)
    key = table * len(fields.materials) + material[:, None]
    own, cells = np.unique(key, return_inverse=True)
    return FieldPoints(
        points_m=nodes[own // len(fields.materials)],
        cells=np.asarray(cells).reshape(table.shape),
        cell_material=material,
        point_material=own % len(fields.materials),
        copies=1,
        angle_rad=0.0,
    )


def _materials(given: OrderFields, fields: BodyFields) -> IntArray:
    """Number of the material of every cell, by its density and moduli."""
    matter = given.ingredients.matter
    found = [f.x.array for f in (matter.density, matter.first_lame, matter.second_lame)]
    miss = np.empty((len(fields.materials), len(found[0])))
    for k, m in enumerate(fields.materials):
        shear = m.youngs_modulus_pa / (2.0 * (1.0 + m.poissons_ratio))
        first = 2.0 * shear * m.poissons_ratio / (1.0 - 2.0 * m.poissons_ratio)
        known = (m.density_kg_per_m3, first, shear)
        scale = (m.density_kg_per_m3, shear, shear)
        parts = zip(found, known, scale, strict=True)
        miss[k] = sum(np.abs(f - value) / size for f, value, size in parts)
    return np.asarray(miss.argmin(axis=0), dtype=np.int64)


def _fit(at: FloatArray, weights: FloatArray, nodes: FloatArray, degree: int) -> FloatArray:
    """Values at the nodes from those at points inside, by the nearest polynomial, (nodes, q)."""
    powers = [p for p in np.ndindex(*(degree + 1,) * at.shape[1]) if sum(p) <= degree]

    def terms(x: FloatArray) -> FloatArray:
        return np.stack([np.prod(x ** np.array(p), axis=1) for p in powers], axis=1)

    root = np.sqrt(np.abs(weights))
    return np.asarray(terms(nodes) @ (np.linalg.pinv(root[:, None] * terms(at)) * root))


def _cell_sizes(points: FieldPoints) -> FloatArray:
    """Areas or volumes of the straight cells."""
    corners = points.points_m[points.cells[:, : points.points_m.shape[1] + 1]]
    return np.asarray(np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])))
