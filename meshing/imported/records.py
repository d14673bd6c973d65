"""Records of a user's own mesh: what a file holds, and what a scene asks of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from solidwhirl.geometry import Body, Interface, Material, RigidDisk
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.prediction import PredictedMesh
from solidwhirl.meshing.records import FloatArray, IntArray

Coupling = Literal["distributing", "rigid"]
Shape = Literal["round", "any"]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, kw_only=True, eq=False)
class ElementBlock:
    """Elements of one kind in a file.

    Attributes
    ----------
    kind
        As meshio names it: "tetra", "hexahedron20", "triangle6", ...; nodes in VTK's order.
    nodes
        (c, k) rows of the file's points.
    """

    kind: str
    nodes: IntArray


@dataclass(frozen=True, kw_only=True, eq=False)
class FileMesh:
    """What a mesh file holds, in its own unit and coordinates.

    Attributes
    ----------
    points
        (n, 3).
    blocks
        Elements of all dimensions.
    element_groups
        Name to block index to rows of that block.
    node_groups
        Name to nodes.
    face_groups
        Name to faces of volume elements, each (f, 3) or (f, 4) corner nodes.
    """

    points: FloatArray
    blocks: tuple[ElementBlock, ...]
    element_groups: Mapping[str, Mapping[int, IntArray]]
    node_groups: Mapping[str, IntArray]
    face_groups: Mapping[str, tuple[IntArray, ...]]


@dataclass(frozen=True, kw_only=True)
class MeshInterface:
    """A surface of a meshed body where bearings, gears or disks attach.

    Attributes
    ----------
    name
        Unique in its body.
    coupling
        How the master node follows the surface.
    group
        Group of facets or nodes of the file; None where a box is given.
    box_m
        Lowest and highest corner, after the mesh is turned onto its axis; facets of the surface
        that lie inside belong to the interface.
    node
        Where the master node is: "axis" (in the plane of the surface's centre of area), "centroid"
        of the surface, or a place [m].
    margin
        What corners may be out of the box and count as inside, over the size of the mesh.
    position_m
        The place, once the mesh is known.
    area_m2, mean_m
        Area and centre of area, once the mesh is known.
    cut_facets, cut_area_m2
        Facets of the surface that the box cuts, which do not belong to the interface, and the area
        that they have inside the box; once the mesh is known.
    """

    name: str
    coupling: Coupling
    group: str | None = None
    box_m: Box | None = None
    node: Literal["axis", "centroid"] | tuple[float, float, float] = "axis"
    margin: float = 1e-9
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    area_m2: float = 0.0
    mean_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    cut_facets: int = 0
    cut_area_m2: float = 0.0


@dataclass(frozen=True, kw_only=True)
class StepSize:
    """Element sizes in a geometry that is read from a STEP file.

    Attributes
    ----------
    size_m
        Largest element edge [m].
    smallest_m
        Smallest edge that curvature may ask for [m].
    around
        Elements around a full circle, from the curvature of the surfaces.
    """

    size_m: float
    smallest_m: float
    around: int


@dataclass(frozen=True, kw_only=True)
class MeshRequest:
    """How a file becomes a body.

    Attributes
    ----------
    path, digest
        The file and the SHA-256 of its content.
    unit_m
        Length unit of its coordinates [m].
    origin, direction
        The axis in the file's unit and coordinates; it becomes z, the origin z = 0.
    x_direction
        What becomes x, but for its part along the axis; None: the smallest turn that takes the
        direction to z.
    material
        Of elements that no group in `materials` has; None: there may be none.
    materials
        (group, material) pairs.
    interfaces
        Surfaces that are looked for.
    shape
        "round": has to be a body of revolution; "any".
    step
        Sizes where the file is a geometry; None: it is a mesh.
    """

    path: str
    digest: str
    unit_m: float
    origin: tuple[float, float, float]
    direction: tuple[float, float, float]
    x_direction: tuple[float, float, float] | None = None
    material: Material | None
    materials: tuple[tuple[str, Material], ...] = ()
    interfaces: tuple[MeshInterface, ...] = ()
    shape: Shape
    step: StepSize | None = None


@dataclass(frozen=True, kw_only=True)
class MassIntegrals:
    """Mass of a mesh; inertia tensor about the centre of gravity by rows."""

    mass_kg: float
    center_of_gravity_m: tuple[float, float, float]
    inertia_kg_m2: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, kw_only=True)
class Roundness:
    """How far a mesh is from a body of revolution.

    Attributes
    ----------
    static_unbalance
        Offset of the centre of gravity over the radius of gyration about the axis.
    uneven_mass
        Largest moment of the mass of circumferential orders 1 and 2, weighted along the axis by
        Legendre polynomials, over the moment without the angle.
    surface
        Largest distance of a turned node of the surface from the surface, over its radius.
    """

    static_unbalance: float
    uneven_mass: float
    surface: float


@dataclass(frozen=True, kw_only=True)
class MeshedBody:
    """A body that comes from a file.

    Attributes
    ----------
    name
        Used in messages.
    request
        Where it comes from.
    interfaces
        With the places of their nodes, once the mesh is known.
    rigid_disks
        Lumped disks on its interfaces.
    expected
        Numbers of its mesh: counted, or predicted for a geometry.
    shortest_m, longest_m
        Shortest and longest edge, or what is asked of them.
    length_m, radius_m, volume_m3
        Overall length along the axis, largest radius, volume.
    mass
        Integrals over the mesh; None before it is made.
    roundness
        None before it is made, or where any shape is allowed.
    """

    name: str
    request: MeshRequest
    interfaces: tuple[MeshInterface, ...]
    rigid_disks: tuple[RigidDisk, ...] = ()
    expected: PredictedMesh
    shortest_m: float
    longest_m: float
    length_m: float
    radius_m: float
    volume_m3: float
    mass: MassIntegrals | None = None
    roundness: Roundness | None = None


#: A body from a profile or from a file, and an interface of it.
AnyBody = Body | MeshedBody
AnyInterface = Interface | MeshInterface


def on_axis(points: FloatArray, request: MeshRequest) -> FloatArray:
    """Coordinates [m] with the axis of the request as z, of points (n, 3) in the file's unit.

    Raises
    ------
    MeshingError
        Directions that are none.
    """
    return np.asarray(request.unit_m * (points - np.array(request.origin)) @ axis_turn(request).T)


def axis_turn(request: MeshRequest) -> FloatArray:
    """Rotation (3, 3) that takes the direction to z.

    Raises
    ------
    MeshingError
        Directions that are none.
    """
    direction = np.array(request.direction, dtype=float)
    length = float(np.linalg.norm(direction))
    if not length > 0.0:
        raise MeshingError("axis.direction has no length")
    z = direction / length
    if request.x_direction is not None:
        x = np.array(request.x_direction, dtype=float)
        x = x - (x @ z) * z
        if float(np.linalg.norm(x)) <= 1e-6 * float(np.linalg.norm(request.x_direction)):
            raise MeshingError("axis.x_direction lies along axis.direction")
        x = x / np.linalg.norm(x)
        return np.array([x, np.cross(z, x), z])
    if z[2] <= -1.0 + 1e-12:
        return np.diag([1.0, -1.0, -1.0])
    # Rodrigues' formula for the smallest turn
    v = np.array([z[1], -z[0], 0.0])
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + z[2]))
