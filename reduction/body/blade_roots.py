"""Roots of the blades of a sector: their sections, and what a cyclic index does to each blade.

In: mesh and operators of one index, fields of its basis. Out: `BladeRoot`, in numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import basix
import numpy as np
import ufl
from dolfinx import fem
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from solidwhirl.geometry import Blade
from solidwhirl.meshing import Mesh
from solidwhirl.meshing.imported.records import AnyBody
from solidwhirl.reduction.operators import compat, forms
from solidwhirl.reduction.operators.cyclic import CyclicIndex
from solidwhirl.reduction.operators.matrices import BodyOperators
from solidwhirl.rotordyn.core.arrays import FloatArray, IntArray, Matrix
from solidwhirl.rotordyn.nodal_diameters import BladeRoot, RootSection

# Components xx, yy, zz, xy, yz, xz of a tensor.
_ROW, _COLUMN = [0, 1, 2, 0, 1, 0], [0, 1, 2, 1, 2, 2]
# Points lie in a plane up to this part of the size.
_NEAR = 1e-9
_FACETS = ((1, 2, 3), (0, 2, 3), (0, 1, 3), (0, 1, 2))


@dataclass(frozen=True, kw_only=True, eq=False)
class MeshedBlade:
    """A blade of a sector, or what half a sector has of it."""

    cells: IntArray  #: (c,) of the mesh
    facets: IntArray  #: (f, 3) corners of its facets on the root
    root_m: FloatArray  #: (f, 3, 3) the same as places
    middle_m: FloatArray  #: (3,) inside of it
    #: Angle of the plane through the axis that cuts it in half, 0 or π/N; None: all of it is there
    cut_rad: float | None


def meshed_blades(body: AnyBody, mesh: Mesh) -> tuple[MeshedBlade, ...]:
    """Return the blades of a sector that a scene describes; a mesh that is given names none."""
    names = {f.name for f in getattr(body, "features", ()) if isinstance(f, Blade)}
    if mesh.sector is None or mesh.parts is not None or not names:
        return ()
    numbers = [k for k, name in enumerate(mesh.section_names) if name in names]
    of_blade = np.isin(mesh.cell_section, numbers)
    corners = mesh.cells[:, :4]
    return tuple(_meshed(mesh, own, of_blade) for own in _pieces(corners, of_blade))


def _pieces(corners: IntArray, chosen: Any) -> Iterator[IntArray]:
    """Chosen cells in connected pieces."""
    cells = np.flatnonzero(chosen)
    nodes, index = np.unique(corners[cells], return_inverse=True)
    index = index.reshape(-1, 4)
    first = np.repeat(index[:, 0], 3)
    graph = coo_array((np.ones(len(first)), (first, index[:, 1:].ravel())), shape=(len(nodes),) * 2)
    count, label = connected_components(graph, directed=False)
    for k in range(count):
        yield cells[label[index[:, 0]] == k]


def _meshed(mesh: Mesh, cells: IntArray, of_blade: Any) -> MeshedBlade:
    corners, points = mesh.cells[:, :4], mesh.points
    both = np.concatenate([_facets(corners[cells]), _facets(corners[~of_blade])])
    found, count = np.unique(both, axis=0, return_counts=True)
    shared = found[count == 2]
    return MeshedBlade(
        cells=cells,
        facets=shared,
        root_m=points[shared],
        middle_m=points[np.unique(corners[cells])].mean(axis=0),
        cut_rad=_cut(mesh, cells),
    )


def _facets(corners: IntArray) -> IntArray:
    """All facets of cells once, corners rising."""
    facets = np.concatenate([corners[:, list(f)] for f in _FACETS])
    return np.asarray(np.unique(np.sort(facets, axis=1), axis=0))


def _cut(mesh: Mesh, cells: IntArray) -> float | None:
    """Which cut of half a sector goes through a blade."""
    assert mesh.sector is not None
    if not mesh.sector.mirrored:
        return None
    points, near = mesh.points[mesh.cells[cells, :4]], _NEAR * float(np.abs(mesh.points).max())
    for angle in (0.0, np.pi / mesh.sector.count):
        off = points[..., 1] * np.cos(angle) - points[..., 0] * np.sin(angle)
        if ((np.abs(off) <= near).sum(axis=1) == 3).any():
            return angle
    return None


def _section(triangles: FloatArray, middle: FloatArray) -> tuple[RootSection, FloatArray]:
    """The plane section that triangles (t, 3, 3) are, its normal towards a point, their parts."""
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    inside = triangles.mean(axis=1)
    # neighbours look to one side: that of the blade
    normals *= np.sign((normals * (middle - inside)).sum(axis=1))[:, None]
    normal = normals.sum(axis=0) / np.linalg.norm(normals.sum(axis=0))
    area = 0.5 * normals @ normal
    centre = area @ inside / area.sum()
    first = np.cross([0.0, 1.0, 0.0] if abs(normal[1]) < 0.7 else [1.0, 0.0, 0.0], normal)
    first /= np.linalg.norm(first)
    axes = np.array([first, np.cross(normal, first), normal])
    flat = (triangles - centre) @ axes[:2].T
    # of a triangle ∫ s sᵀ dA = A/12 (Σ s sᵀ + 9 m mᵀ) of its corners and their mean
    mean = flat.mean(axis=1)
    corners = np.einsum("tki,tkj->tij", flat, flat) + 9.0 * mean[:, :, None] * mean[:, None, :]
    section = RootSection(
        area_m2=float(area.sum()),
        centre_m=centre,
        axes=axes,
        points_m=np.unique(flat.reshape(-1, 2), axis=0),
        second_moments_m4=np.einsum("t,tij->ij", area, corners) / 12.0,
    )
    return section, area / area.sum()


def blade_roots(
    blades: Sequence[MeshedBlade], mesh: Mesh, operators: BodyOperators, vectors: Matrix,
    at_nodes: Callable[[FloatArray], Matrix],
) -> tuple[BladeRoot, ...]:  # fmt: skip
    """Return the roots of blades in the coordinates of a basis.

    `vectors`: (unknowns, n) of one process. `at_nodes`: takes corners of the mesh, (m, 3), and
    returns Φ of the basis there, (m, 3, n).
    """
    if not blades:
        return ()
    space, cyclic = operators.space, operators.ingredients.kinematics.cyclic
    assert cyclic is not None
    nodes, table = compat.straight_cells(space.mesh)
    # cells are renumbered: found again by their middles
    middles = mesh.points[mesh.cells[:, :4]].mean(axis=1)
    there = cKDTree(nodes[table].mean(axis=1)).query(middles)[1]
    fields = operators.coupling.unknowns.displacement(vectors)
    found: list[BladeRoot] = []
    for blade in blades:
        beside = blade.cells[np.isin(mesh.cells[blade.cells, :4], blade.facets).any(axis=1)]
        loads = _moment_loads(operators, there[blade.cells])
        known = _Found(
            # of a translation along x
            first=loads[::3, 1:, 0].sum(axis=0),
            moments=np.tensordot(loads, fields, axes=(0, 0)),
            root=at_nodes(blade.root_m.reshape(-1, 3)).reshape(*blade.root_m.shape, -1),
            stress=_stress(operators, fields, there[beside]),
        )
        found += _roots(blade, known, cyclic)
    return tuple(found)


class _Found(NamedTuple):
    """What the mesh has of a blade; fields are Φ1 + iΦ2 of every coordinate."""

    first: FloatArray  #: (3,) ∫ρ x dV
    moments: Matrix  #: (4, 3, n) ∫ρ u dV and ∫ρ x_j u dV
    root: Matrix  #: (f, 3, 3, n) u of the corners of the root's facets
    stress: Matrix  #: (q, 6, n)

    def image(self, cyclic: CyclicIndex, angle: float) -> _Found:
        """The mirror image in a plane through the axis, 0 or π/N."""
        mirror = _mirror(angle)
        factor = np.exp(2j * cyclic.index * angle)
        if cyclic.is_real:
            factor = factor.real

        def turned(values: Matrix) -> Matrix:
            other = np.conj(values)
            own = other.real + other.imag if cyclic.is_real else other
            return np.asarray(factor * np.einsum("ij,...jn->...in", mirror, own))

        moments = turned(self.moments)
        moments[1:] = np.tensordot(mirror, moments[1:], axes=1)
        inside = np.conj(self.stress)
        return _Found(
            first=mirror @ self.first,
            moments=moments,
            root=turned(self.root),
            # in axes of its own, which matter to no measure of it
            stress=inside.real + inside.imag if cyclic.is_real else inside,
        )

    def itself(self, cyclic: CyclicIndex) -> _Found:
        """The same with the field as it is: of a real one Φ1 + Φ2."""
        if not cyclic.is_real:
            return self
        return self._replace(
            **{k: (v := getattr(self, k)).real + v.imag for k in ("moments", "root", "stress")}
        )


def _mirror(angle: float) -> FloatArray:
    """Reflection in the plane through the axis at an angle."""
    c, s = np.cos(2.0 * angle), np.sin(2.0 * angle)
    return np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, 1.0]])


def _roots(blade: MeshedBlade, known: _Found, cyclic: CyclicIndex) -> Iterator[BladeRoot]:
    """The blade, and its mirror image where half a sector has but one of them."""
    own, places = known.itself(cyclic), blade.root_m
    if not cyclic.sector.mirrored:
        yield _root(places, blade.middle_m, own)
        return
    angle = blade.cut_rad or 0.0
    other = known.image(cyclic, angle)
    mirror = _mirror(angle)
    if blade.cut_rad is None:
        yield _root(places, blade.middle_m, own)
        yield _root(places @ mirror, mirror @ blade.middle_m, other)
        return
    whole = _Found(
        first=own.first + other.first,
        moments=own.moments + other.moments,
        root=np.concatenate([own.root, other.root]),
        stress=np.concatenate([own.stress, other.stress]),
    )
    middle = 0.5 * (blade.middle_m + mirror @ blade.middle_m)
    yield _root(np.concatenate([places, places @ mirror]), middle, whole)


def _root(places: FloatArray, middle: FloatArray, known: _Found) -> BladeRoot:
    section, part = _section(places, middle)
    return BladeRoot(
        section=section,
        first_moment_kg_m=known.first,
        momentum=known.moments[0],
        moments=known.moments[1:].transpose(1, 0, 2),
        centre=np.einsum("f,fin->in", part, known.root.mean(axis=1)),
        stress_pa=known.stress,
    )


def _moment_loads(operators: BodyOperators, cells: IntArray) -> FloatArray:
    """Loads v ↦ ∫ρ v_i dV and ∫ρ x_j v_i dV over cells, (unknowns of the space, 4, 3)."""
    space, kin = operators.space, operators.ingredients.kinematics
    density = operators.ingredients.matter.density
    own = fem.Function(density.function_space)
    own.x.array[cells] = density.x.array[cells]
    offset, slope = (fem.Constant(space.mesh, np.zeros(shape)) for shape in ((3,), (3, 3)))
    place = ufl.SpatialCoordinate(space.mesh)
    load = ufl.inner(ufl.dot(slope, place) + offset, ufl.TestFunction(space)) * own
    form = compat.compiled(load * forms.measure(space.mesh, kin, compat.polynomial_degree(space)))
    out = []
    for j in range(4):
        for i in range(3):
            offset.value[:], slope.value[:] = 0.0, 0.0
            if j:
                slope.value[i, j - 1] = 1.0
            else:
                offset.value[i] = 1.0
            out.append(compat.assembled_vector(form))
    return np.asarray(np.stack(out, axis=1).reshape(-1, 4, 3))


def _stress(operators: BodyOperators, fields: Matrix, cells: IntArray) -> Matrix:
    """Stress (q, 6, n) of fields at the points of Barlow of some cells."""
    space, made = operators.space, operators.ingredients
    field = fem.Function(space)
    degree = compat.polynomial_degree(space)
    at, _ = basix.make_quadrature(basix.CellType.tetrahedron, 2 * (degree - 1))
    found = compat.expression(forms.stress(made.kinematics, made.matter, field), at)

    def sampled(values: FloatArray) -> FloatArray:
        compat.owned_values(field)[:] = values
        field.x.scatter_forward()
        every = compat.evaluated(found, space.mesh).reshape(-1, len(at), 3, 3)
        return np.asarray(every[cells][:, :, _ROW, _COLUMN].reshape(-1, 6))

    columns = [sampled(v.real) + 1j * sampled(v.imag) for v in fields.T]
    return np.stack(columns, axis=2)
