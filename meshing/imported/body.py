"""A user's own mesh as a body: on its axis, in metres, checked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy

from solidwhirl.geometry import RigidDisk
from solidwhirl.meshing.errors import MeshingError
from solidwhirl.meshing.imported import measures, sectors
from solidwhirl.meshing.imported.fitted import fitted_mesh
from solidwhirl.meshing.imported.formats.files import read_mesh_file
from solidwhirl.meshing.imported.groups import (
    cell_materials,
    interface_facets,
    sections_of,
    volume_groups,
)
from solidwhirl.meshing.imported.masses import nodal_masses
from solidwhirl.meshing.imported.records import (
    FileMesh,
    MeshedBody,
    MeshInterface,
    MeshRequest,
    Roundness,
    on_axis,
)
from solidwhirl.meshing.imported.split import as_tetrahedra
from solidwhirl.meshing.imported.surface import faces_of, place_text, refuse_unjoined
from solidwhirl.meshing.own.meridian import checked_quality, compact
from solidwhirl.meshing.own.prediction import PredictedMesh
from solidwhirl.meshing.own.revolved import unfolded
from solidwhirl.meshing.records import FloatArray, IntArray, Mesh, MeshSize, Sector

#: What a turning body may be off a body of revolution, see `Roundness`; and its interfaces.
ROUNDNESS_LIMITS = {"static_unbalance": 5e-3, "uneven_mass": 1e-2, "surface": 5e-2}
_UNEVEN_INTERFACE = 0.1
# Corners of the surface that pictures are drawn from, at most.
_MOST_SHOWN = 400
# Coordinates of a node below this part of the mesh's size are rounding.
_ON_AXIS = 1e-9
# How exactly curves of a geometry lie on the planes of boxes, over the size of the body.
_CUT_EXACTLY = 1e-6
# Distance of a surface from its node, over its radius of gyration, that a tie can carry.
_FARTHEST = 3.0
# Point masses nearer to the axis than this part of the radius are on it.
_MASS_ON_AXIS = 0.01
# Spread of a surface across its length over that along it below which it is a line.
_SMALLEST_SPREAD = 1e-9


def mesh_from_file(request: MeshRequest, name: str) -> Mesh:
    """Read a mesh file as a body: second-order tetrahedra, straight where it has no middles.

    Raises MeshingError: what can't be read, does not hang together, is folded, or lacks a group.
    """
    return mesh_of(read_mesh_file(request.path), request, name)


def mesh_of(found: FileMesh, request: MeshRequest, name: str) -> Mesh:
    """Make the mesh of a body of what a file holds."""
    found = replace(found, points=on_axis(found.points, request))
    if request.joints:
        return fitted_mesh(found, request, name)
    if request.sectors is not None:
        parts = tuple(group for group, _ in request.materials)
        found = sectors.one_sector(found, request.sectors, parts)
    tetrahedra = as_tetrahedra(found)
    cells, points, used = compact(tetrahedra.points, tetrahedra.cells)
    tetrahedra = replace(
        tetrahedra,
        points=points,
        cells=cells,
        corner_row=np.where(tetrahedra.corner_row < 0, -1, used[tetrahedra.corner_row]),
    )
    faces = faces_of(cells)
    refuse_unjoined(points, cells, faces)
    groups = volume_groups(found, tetrahedra)
    material, materials = cell_materials(request, groups, len(cells))
    sector, where = None, f"body {name!r}"
    if request.sectors is None:
        points, quality = checked_quality(points, cells, where)
    else:
        sector = Sector(count=request.sectors, mirrored=False)
        points, faces, quality = sectors.joined_sector(points, cells, faces, sector.count, where)
    section, names = sections_of(groups, len(cells))
    shortest, longest = edge_lengths(points, cells)
    nodes, masses = nodal_masses(found, request, points, shortest)
    surface = np.unique(faces.nodes[faces.outside][:, :3])
    return Mesh(
        points=points,
        cells=cells,
        cell_section=section,
        cell_material=material,
        materials=materials,
        section_names=names,
        interfaces={
            i.name: interface_facets(found, tetrahedra, points, faces, i, request.sectors)
            for i in _with_margins(request)
        },
        outline=surface[:: max(1, -(-len(surface) // _MOST_SHOWN))].copy(),
        size=MeshSize(size_m=longest, corner_size_m=shortest),
        quality=quality,
        sector=sector,
        mass_nodes=nodes,
        node_masses_kg=masses,
    )


def _with_margins(request: MeshRequest) -> tuple[MeshInterface, ...]:
    """The interfaces; where boxes were cut into a geometry, as exactly as its kernel cuts."""
    if request.step is None:
        return request.interfaces
    return tuple(replace(i, margin=_CUT_EXACTLY) for i in request.interfaces)


def edge_lengths(points: FloatArray, cells: IntArray) -> tuple[float, float]:
    """Shortest and longest edge of the cells, between corners [m]."""
    corner = points[cells[:, :4]]
    lengths = [
        np.linalg.norm(corner[:, i] - corner[:, j], axis=1) for i in range(4) for j in range(i)
    ]
    return float(np.min(lengths)), float(np.max(lengths))


def counts_of(mesh: Mesh) -> PredictedMesh:
    """Numbers of a mesh that is there.

    `mesh`: second-order tetrahedra.
    """
    vertices = len(np.unique(mesh.cells[:, :4]))
    edges = len(mesh.points) - vertices
    # by Euler's formula of a ball; a hole more or less is a few in thousands
    return PredictedMesh(
        dimension=3,
        cells=len(mesh.cells),
        vertices=vertices,
        edges=edges,
        facets=max(1 + edges + len(mesh.cells) - vertices, 0),
        graded_places=0,
    )


def body_of_mesh(
    name: str, request: MeshRequest, mesh: Mesh, rigid_disks: tuple[RigidDisk, ...] = ()
) -> MeshedBody:
    """Describe a body by its mesh: places of its interfaces, mass, size, roundness.

    Raises MeshingError: a turning body that is none of revolution, or an interface that can't be
    one.
    """
    if request.shape == "asymmetric":
        _refuse_beside(name, mesh)
    expected = counts_of(mesh)
    if mesh.sector is not None and mesh.sector.mirrored:
        mesh = unfolded(mesh)
    count = None if mesh.sector is None else mesh.sector.count
    outside = sectors.outer_facets(mesh.points, mesh.cells, count)
    placed = tuple(
        measures.measured(_placed(i, mesh, request), mesh, outside) for i in _with_margins(request)
    )
    round_to = None
    if request.shape == "round":
        round_to = measures.roundness(mesh, _round_faces(mesh))
        _refuse_uneven(name, round_to)
        if len(_beside_axis(mesh)):
            raise MeshingError(
                f"body {name!r} has point masses off its axis: it is asymmetric; "
                'say symmetry = "none", or sectors'
            )
    return MeshedBody(
        name=name,
        request=request,
        interfaces=placed,
        rigid_disks=rigid_disks,
        expected=expected,
        shortest_m=mesh.size.corner_size_m,
        longest_m=mesh.size.size_m,
        length_m=float(np.ptp(mesh.points[:, 2])),
        radius_m=float(np.hypot(mesh.points[:, 0], mesh.points[:, 1]).max()),
        volume_m3=measures.volume_m3(mesh),
        mass=measures.mass_integrals(mesh),
        roundness=round_to,
    )


def _round_faces(mesh: Mesh) -> IntArray:
    """The surface, and faces between materials."""
    faces = faces_of(mesh.cells)
    a, b = faces.cells.T
    between = ~faces.outside & (mesh.cell_material[a] != mesh.cell_material[b])
    return np.asarray(faces.nodes[faces.outside | between])


def is_round(mesh: Mesh) -> bool:
    """Whether a whole mesh is near enough to a body of revolution to be taken as one."""
    return _is_even(measures.roundness(mesh, _round_faces(mesh))) and not len(_beside_axis(mesh))


def _beside_axis(mesh: Mesh) -> IntArray:
    """Nodes with point masses off the axis, whose motion depends on the angle."""
    nodes = mesh.mass_nodes
    radius = np.hypot(mesh.points[:, 0], mesh.points[:, 1])
    return np.asarray(nodes[radius[nodes] > _MASS_ON_AXIS * radius.max()])


def _is_even(found: Roundness) -> bool:
    return all(getattr(found, key) <= limit for key, limit in ROUNDNESS_LIMITS.items())


def _refuse_uneven(name: str, found: Roundness) -> None:
    values = {key: float(getattr(found, key)) for key in ROUNDNESS_LIMITS}
    if _is_even(found):
        return
    limits = ROUNDNESS_LIMITS
    reason = "it is no body of revolution about its axis"
    if all(values[k] <= limits[k] for k in ("static_unbalance", "uneven_mass")):
        reason = (
            "its mass is even around the axis, but its surface is not, as with blades, holes, or "
            "fewer than about 10 straight edges around"
        )
    raise MeshingError(
        f"body {name!r} turns, but {reason}: static unbalance {values['static_unbalance']:.2g} of "
        f"the radius of gyration (allowed {limits['static_unbalance']:g}), uneven mass "
        f"{values['uneven_mass']:.2g} (allowed {limits['uneven_mass']:g}), surface off "
        f"by {values['surface']:.2g} of its radius when turned (allowed {limits['surface']:g}). If "
        "it consists of 3 or more equal sectors, say how many (sectors); if it is meant to be "
        'asymmetric, say symmetry = "none"; else leave blades and details out of the mesh and '
        "give their mass as rigid_disks, or check axis.origin and axis.direction"
    )


def _placed(interface: MeshInterface, mesh: Mesh, request: MeshRequest) -> MeshInterface:
    """The interface with the place of its node."""
    where = f"interface {interface.name!r}"
    facets = mesh.interfaces[interface.name]
    corner = measures.flat_pieces(mesh.points, facets)
    area = 0.5 * np.linalg.norm(
        np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1
    )
    # three points at the middles of the sides integrate squares
    middles = 0.5 * (corner + np.roll(corner, -1, axis=1))
    weight = np.repeat(area / 3.0, 3)
    x = middles.reshape(-1, 3)
    centre = weight @ x / weight.sum()
    second = x.T @ (weight[:, None] * x) / weight.sum()
    if mesh.sector is not None:
        centre, second = measures.evenly_turned(centre, second)
    centre[np.abs(centre) < _ON_AXIS * np.abs(mesh.points).max()] = 0.0
    spread = np.linalg.eigvalsh(second - np.outer(centre, centre))
    if spread[1] <= _SMALLEST_SPREAD * spread[2]:
        raise MeshingError(f"{where}: its facets lie in a line and determine no rotation")
    if request.shape == "round":
        _refuse_uneven_interface(where, x, weight)
    if request.shape != "any" and not isinstance(interface.node, str) and any(interface.node[:2]):
        raise MeshingError(
            f"{where}: node_m is {list(interface.node)}; the nodes of a body that turns lie on its "
            "axis"
        )
    if request.shape == "asymmetric":
        _refuse_far(where, centre, float(np.sqrt(spread[1:].sum())))
    place = (0.0, 0.0, float(centre[2]))
    if interface.node == "centroid" and request.shape == "any":
        place = (float(centre[0]), float(centre[1]), float(centre[2]))
    elif not isinstance(interface.node, str):
        place = interface.node
    return replace(interface, position_m=place)


def _refuse_beside(name: str, mesh: Mesh) -> None:
    """A body that its axis does not meet, seen along it, turns about nothing that holds it."""
    edges = scipy.spatial.ConvexHull(mesh.points[:, :2]).equations
    away = float(edges[:, 2].max())
    if away > 0.0:
        raise MeshingError(
            f"body {name!r} lies beside its axis: seen along it, the axis passes {away:.3g} m "
            f"outside of what encloses the mesh, x from {mesh.points[:, 0].min():.4g} to "
            f"{mesh.points[:, 0].max():.4g} m and y from {mesh.points[:, 1].min():.4g} to "
            f"{mesh.points[:, 1].max():.4g} m about the axis; check axis.origin, axis.direction "
            "and length_unit; if it is one of 3 or more equal sectors, say how many (sectors)"
        )


def _refuse_far(where: str, centre: FloatArray, extent: float) -> None:
    """A surface far from its node on the axis would be tied through nothing."""
    away = float(np.hypot(centre[0], centre[1]))
    if away > _FARTHEST * extent:
        raise MeshingError(
            f"{where}: its surface lies {away:.3g} m off the axis and extends over {extent:.3g} m "
            f"(its radius of gyration; allowed is {_FARTHEST:g} times that): a tie to a node on "
            "the axis would be an arm that is not there; take a surface about the axis, or check "
            "axis.origin and axis.direction"
        )


def _refuse_uneven_interface(where: str, x: FloatArray, weight: FloatArray) -> None:
    """A surface that does not go all around holds a turning body at one angle only."""
    around = x[:, 0] + 1j * x[:, 1]
    even = [max(float(weight @ np.abs(around) ** m), 1e-300) for m in (1, 2)]
    uneven = [abs(complex(weight @ around**m)) / even[m - 1] for m in (1, 2)]
    if max(uneven) > _UNEVEN_INTERFACE:
        raise MeshingError(
            f"{where}: its facets do not go evenly around the axis (moments of orders 1 and 2 "
            f"are {uneven[0]:.2g} and {uneven[1]:.2g}, allowed {_UNEVEN_INTERFACE:g}); the first "
            f"lies at {place_text(x[0])} m"
        )
