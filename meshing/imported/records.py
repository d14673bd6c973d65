"""Records of a user's own mesh: what a file holds, and what a scene asks of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np

from solidwhirl.geometry import Body, Interface, Joint, Material, RigidDisk, symmetry
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.own.prediction import PredictedMesh
from solidwhirl.meshing.records import FloatArray, IntArray

Coupling = Literal["distributing", "rigid"]
Shape = Literal["round", "cyclic", "asymmetric", "any"]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True, kw_only=True, eq=False)
class ElementBlock:
    """Elements of one kind in a file."""

    #: As meshio names it: "tetra", "hexahedron20", "triangle6", ...; nodes in VTK's order
    kind: str
    nodes: IntArray  #: (c, k) rows of the file's points


@dataclass(frozen=True, kw_only=True, eq=False)
class PointMass:
    """A rigid mass on a node of a file, in its units."""

    label: str  #: As the file calls it, "CONM2 7"
    node: int  #: Row of the file's points
    mass: float
    #: Centre of gravity from the node, and inertia tensor about it
    offset: FloatArray = field(default_factory=lambda: np.zeros(3))
    inertia: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, kw_only=True, eq=False)
class FileCoupling:
    """A reference node of a file, and how it follows a surface of a body, or that it."""

    #: That of the group of facets or nodes which it couples
    name: str
    label: str  #: As the file calls it, with the line: "RBE2 7 (line 30)"
    coupling: Coupling
    node: int  #: Row of the file's points
    group: str = ""  #: Another name of what it couples: that of its surface or set in the file


@dataclass(frozen=True, kw_only=True, eq=False)
class FileMesh:
    """What a mesh file holds, in its own unit and coordinates."""

    points: FloatArray  #: (n, 3)
    blocks: tuple[ElementBlock, ...]  #: Elements of all dimensions
    #: Name to block index to rows of that block
    element_groups: Mapping[str, Mapping[int, IntArray]]
    node_groups: Mapping[str, IntArray] = field(default_factory=dict)  #: Name to nodes
    #: Name to faces of volume elements, each (f, 3) or (f, 4) corner nodes
    face_groups: Mapping[str, tuple[IntArray, ...]] = field(default_factory=dict)
    masses: tuple[PointMass, ...] = ()
    couplings: tuple[FileCoupling, ...] = ()
    #: Densities that the file gives its materials: they tell its unit of mass
    densities: tuple[float, ...] = ()
    #: What its masses and densities are multiplied by in a consistent set of units (Nastran)
    mass_factor: float = 1.0
    files: tuple[Path, ...] = ()  #: Those that were read, included ones too
    remarks: tuple[str, ...] = ()  #: What was left out, and why that may matter


@dataclass(frozen=True, kw_only=True)
class MeshInterface:
    """A surface of a meshed body where bearings, gears or disks attach."""

    name: str  #: Unique in its body
    coupling: Coupling  #: How the master node follows the surface
    group: str | None = None  #: Group of facets or nodes of the file; None where a box is given
    #: Lowest and highest corner, after the mesh is turned onto its axis; facets of the surface that
    #: lie inside belong to the interface
    box_m: Box | None = None
    #: Where the master node is: "axis" (in the plane of the surface's centre of area), "centroid"
    #: of the surface, or a place [m]
    node: Literal["axis", "centroid"] | tuple[float, float, float] = "axis"
    #: What corners may be out of the box and count as inside, over the size of the mesh
    margin: float = 1e-9
    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)  #: The place, once the mesh is known
    #: Area and centre of area, once the mesh is known
    area_m2: float = 0.0
    mean_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Facets of the surface that the box cuts, which do not belong to the interface, and the area
    #: that they have inside the box; once the mesh is known
    cut_facets: int = 0
    cut_area_m2: float = 0.0


@dataclass(frozen=True, kw_only=True)
class StepSize:
    """Element sizes in a geometry that is read from a STEP file."""

    size_m: float  #: Largest element edge [m]
    smallest_m: float  #: Smallest edge that curvature may ask for [m]
    around: int  #: Elements around a full circle, from the curvature of the surfaces


@dataclass(frozen=True, kw_only=True)
class MeshRequest:
    """How a file becomes a body."""

    #: The file and the SHA-256 of its content
    path: str
    digest: str
    unit_m: float  #: Length unit of its coordinates [m]
    #: The axis in the file's unit and coordinates; it becomes z, the origin z = 0
    origin: tuple[float, float, float]
    direction: tuple[float, float, float]
    #: What becomes x, but for its part along the axis; None: the smallest turn that takes the
    #: direction to z
    x_direction: tuple[float, float, float] | None = None
    #: Of elements that no group in `materials` has; None: there may be none
    material: Material | None
    materials: tuple[tuple[str, Material], ...] = ()  #: (group, material) pairs
    interfaces: tuple[MeshInterface, ...] = ()  #: Surfaces that are looked for
    #: "round": has to be a body of revolution; "cyclic": consists of equal sectors; "asymmetric":
    #: turns, whatever its shape; "any": stands still
    shape: Shape
    sectors: int | None = None  #: Equal sectors N of a cyclic body, whose mesh is one; else None
    mass_unit_kg: float | None = None  #: Of the file's masses; None: goes with its unit of length
    step: StepSize | None = None  #: Sizes where the file is a geometry; None: it is a mesh
    #: Between solids of a geometry, by their labels: it is of revolution, and meshed from its
    #: meridian. One that says nothing has the interference that is drawn
    joints: tuple[Joint, ...] = ()


@dataclass(frozen=True, kw_only=True)
class MassIntegrals:
    """Mass of a mesh; inertia tensor about the centre of gravity by rows."""

    mass_kg: float
    center_of_gravity_m: tuple[float, float, float]
    inertia_kg_m2: tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, kw_only=True)
class Roundness:
    """How far a mesh is from a body of revolution."""

    #: Offset of the centre of gravity over the radius of gyration about the axis
    static_unbalance: float
    #: Largest moment of the mass of circumferential orders 1 and 2, weighted along the axis by
    #: Legendre polynomials, over the moment without the angle
    uneven_mass: float
    #: Largest distance of a turned node of the surface from the surface, over its radius
    surface: float


@dataclass(frozen=True, kw_only=True)
class MeshedBody:
    """A body that comes from a file."""

    name: str  #: Used in messages
    request: MeshRequest  #: Where it comes from
    interfaces: tuple[MeshInterface, ...]  #: With the places of their nodes, once the mesh is known
    rigid_disks: tuple[RigidDisk, ...] = ()  #: Lumped disks on its interfaces
    #: Numbers of its mesh, of a cyclic body of one sector: counted, or predicted for a geometry
    expected: PredictedMesh
    #: Shortest and longest edge, or what is asked of them
    shortest_m: float
    longest_m: float
    #: Overall length along the axis, largest radius, volume (of all sectors)
    length_m: float
    radius_m: float
    volume_m3: float
    mass: MassIntegrals | None = None  #: Of the whole body; None before the mesh is made
    roundness: Roundness | None = None  #: None before it is made, or where any shape is allowed
    remarks: tuple[str, ...] = ()  #: What of its file was left out

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Between its solids, with the interference that is drawn."""
        return self.request.joints


#: A body from a profile or from a file, and an interface of it.
AnyBody = Body | MeshedBody


def is_asymmetric(body: AnyBody) -> bool:
    """Whether a body turns and is asymmetric."""
    if isinstance(body, MeshedBody):
        return body.request.shape == "asymmetric"
    return symmetry(body) == "asymmetric"


AnyInterface = Interface | MeshInterface


def on_axis(points: FloatArray, request: MeshRequest) -> FloatArray:
    """Coordinates [m] with the axis of the request as z, of points (n, 3) in the file's unit.

    Raises MeshingError: directions that are none.
    """
    return np.asarray(request.unit_m * (points - np.array(request.origin)) @ axis_turn(request).T)


def axis_turn(request: MeshRequest) -> FloatArray:
    """Rotation (3, 3) that takes the direction to z.

    Raises MeshingError: directions that are none.
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
