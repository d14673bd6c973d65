"""Records of the meshing stage: what is asked of a mesh, and the meshes themselves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from solidwhirl.geometry import Material
from solidwhirl.meshing.errors import MeshingError

FloatArray = np.ndarray[Any, np.dtype[np.float64]]
IntArray = np.ndarray[Any, np.dtype[np.int64]]


@dataclass(frozen=True, kw_only=True)
class MeshSize:
    """What is asked of a mesh."""

    size_m: float  #: Largest element edge [m]
    corner_size_m: float  #: Element edge at the re-entrant corners of the meridian [m]
    #: Growth of the edge length per metre of distance from a corner (dimensionless, > 0)
    growth: float = 0.3
    through_thickness: float = 1.0  #: Elements asked for across the smaller dimension of a section
    around: int = 16  #: Elements asked for around the circumference (solid meshes only)

    def __post_init__(self) -> None:
        """Refuse sizes that no mesh can have."""
        for name in ("size_m", "corner_size_m", "growth", "through_thickness", "around"):
            value = getattr(self, name)
            if not np.isfinite(value) or value <= 0:
                raise MeshingError(f"mesh {name} is {value}; a positive number is needed")
        if self.corner_size_m > self.size_m:
            raise MeshingError(
                f"mesh corner_size_m = {self.corner_size_m} is larger than size_m = {self.size_m}"
            )


@dataclass(frozen=True, kw_only=True, eq=False)
class LocalSize:
    """Element sizes wanted over a meridian or a sector, linear in the cells of an earlier mesh."""

    points: FloatArray  #: (m, 2) places (z, r) [m], or (m, 3) x, y, z
    cells: IntArray  #: (c, 3) corners of the triangles, or (c, 4) of tetrahedra
    size_m: FloatArray  #: (m,) element edge at the points [m]
    #: (z, r, h): places with an element edge of their own, from which it grows
    places: tuple[tuple[float, float, float], ...] = ()
    growth: float = 0.6  #: Growth of the edge per metre of distance from these places

    def __post_init__(self) -> None:
        """Refuse sizes that no mesh can have; make the arrays read-only."""
        if not (np.isfinite(self.size_m).all() and (self.size_m > 0.0).all()):
            raise MeshingError("mesh size_m of the local sizes must be positive everywhere")
        for array in (self.points, self.cells, self.size_m):
            array.setflags(write=False)


@dataclass(frozen=True, kw_only=True)
class MeshQuality:
    """Quality of the curved elements."""

    #: Smallest scaled Jacobian over all elements (1: ideal simplex, <= 0: folded), a guaranteed
    #: lower bound (Bernstein coefficients), not a sample
    minimum_scaled_jacobian: float
    mean_scaled_jacobian: float  #: Mean over the elements of the same bound
    #: Elements whose curved edges were made straight because they were folded or nearly so
    straightened_elements: int = 0


@dataclass(frozen=True, kw_only=True)
class Sector:
    """Which part of a solid a mesh is: copies of it, turned about z, make the whole."""

    #: Equal sectors N of the whole, each of the angle 2π/N; 1 and 2 on the way to the whole only
    count: int
    #: Whether the mesh is half of a sector, 0 <= θ <= π/N, whose other half is its mirror image in
    #: the plane θ = 0. Otherwise it is a whole sector with two cut faces of any shape: nodes of the
    #: one, turned by 2π/N, are nodes of the other.
    mirrored: bool
    #: Of the body at which the mesh has θ = 0 [rad]
    angle_rad: float = 0.0

    def __post_init__(self) -> None:
        """Refuse no sectors."""
        if self.count < 1:
            raise MeshingError(f"a sector of {self.count}; at least 1 is needed")

    @property
    def copies(self) -> int:
        """Copies of the mesh, mirrored ones too, that make the whole."""
        return 2 * self.count if self.mirrored else self.count


@dataclass(frozen=True, kw_only=True, eq=False)
class Parts:
    """Parts of a mesh with sectors of different counts: a drum, stages, copies of the drum.

    They have no nodes in common; where they meet, they follow one field along the joints.
    """

    sectors: tuple[Sector, ...]  #: By part; the drum is the first
    #: By part, of the drum and its copies: what is added to the cyclic index; None: a stage
    shifts: tuple[int | None, ...]
    cell_part: IntArray  #: (c,) part of every cell
    joint_facets: IntArray  #: (f, 6) facets of all parts on the joints
    joint_edges_m: FloatArray  #: (e, 2, 2) ends (z, r) of the meridian's edges there

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for array in (self.cell_part, self.joint_facets, self.joint_edges_m):
            array.setflags(write=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Mesh:
    """A second-order simplex mesh of the meridian (triangles) or of the solid (tetrahedra)."""

    points: FloatArray  #: (n, d) node coordinates [m]; d = 2: (z, r), d = 3: (x, y, z)
    cells: IntArray  #: (c, 6) or (c, 10) node numbers of the cells, gmsh's node order
    cell_section: IntArray  #: (c,) index into ``section_names`` of every cell
    cell_material: IntArray  #: (c,) index into ``materials`` of every cell
    materials: tuple[Material, ...]  #: Materials by index
    section_names: tuple[str, ...]  #: Names of the profile's sections
    #: Name to (f, 3) or (f, 6) nodes of the facets of every interface
    interfaces: Mapping[str, IntArray]
    #: (k,) nodes on the boundary of the meridian at θ = 0, of the whole of a body with features at
    #: another angle (pictures are drawn from these)
    outline: IntArray
    size: MeshSize  #: What was asked
    quality: MeshQuality  #: What was got
    sector: Sector | None = None  #: Of a solid: which part it is; None: it is the whole
    parts: Parts | None = None  #: Where sectors differ; `sector` is then that of the drum
    #: Of every joint of the body, (f, 2, 3) or (f, 2, 6) nodes of the facets that carry: of the
    #: first section's side and, at the same places, of the second's
    seats: tuple[IntArray, ...] = ()
    #: What a solid with joints was revolved from: on it the state of their faces is found
    meridian: Mesh | None = None
    #: (k,) nodes of a solid with point masses on them, of a sector each in all sectors, and those
    mass_nodes: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    node_masses_kg: FloatArray = field(default_factory=lambda: np.empty(0))

    @property
    def dimension(self) -> int:
        """2 for a meridian mesh, 3 for a solid mesh."""
        return int(self.points.shape[1])

    @property
    def points_in_space(self) -> FloatArray:
        """Nodes x, y, z [m], (n, 3): a meridian in the plane y = 0 with x = r, in the solid."""
        if self.dimension == 3:
            return self.points
        z, r = self.points.T
        return np.column_stack([r, np.zeros(len(r)), z])

    @property
    def facet_sets(self) -> Mapping[str, IntArray]:
        """Facets of the interfaces, and of either side of joints (`seat_name`)."""
        sides = {
            seat_name(joint, side): facets[:, side]
            for joint, facets in enumerate(self.seats)
            for side in range(2)
        }
        return {**self.interfaces, **sides}

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        own = (self.points, self.cells, self.cell_section, self.cell_material, self.outline)
        for array in (*own, *self.seats):
            array.setflags(write=False)


def seat_name(joint: int, side: int) -> str:
    """Name of the facets of one side of a joint, which no interface can have."""
    return f"joint {joint}, side {side}"
