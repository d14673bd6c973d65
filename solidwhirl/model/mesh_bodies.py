"""From the mesh bodies of a scene to meshes and what the program needs to know of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from functools import lru_cache
from itertools import combinations
from pathlib import Path
from typing import Any

from solidwhirl.core.errors import clean
from solidwhirl.geometry import Body, GeometryError, Joint, Material, RigidDisk
from solidwhirl.meshing import Mesh, MeshingError, MeshSize
from solidwhirl.meshing.imported.records import (
    MeshedBody,
    MeshInterface,
    MeshRequest,
    Shape,
    StepSize,
)
from solidwhirl.model.bodies import known_material, scene_materials
from solidwhirl.model.mesh_files import content_digest, read_mesh
from solidwhirl.model.plan_records import BodyPlan
from solidwhirl.model.resolution import Resolution
from solidwhirl.rotordyn.superelement.validation import MOTIONS
from solidwhirl.scene.meshes import MASSES_KG, UNITS_M, MeshBodySpec, MeshInterfaceSpec
from solidwhirl.scene.records import Scene

# Smallest edge that curvature may ask for in a STEP file, over the largest, unless it is given.
_SMALLEST = 0.2
# Elements of the mesh that tells whether a geometry is of revolution, over those asked for, and its
# edges around: fewer make no circle.
_COARSE, _EDGES = 3.0, 16
# and no more elements than about these.
_COARSE_CELLS = 30_000
# What the mesh of a sector may lose of the volume of its geometry: periodic faces can go wrong.
_LOST = 0.01


def build_mesh_bodies(scene: Scene) -> dict[str, MeshedBody]:
    """Read the mesh files of a scene, and look at its STEP files.

    Places of interfaces, mass and roundness are known of mesh files only, those of STEP files when
    they are meshed. Raises GeometryError, MeshingError: unknown material, or a file that is no
    body; the message begins with the key.
    """
    return {name: _built(scene, name, spec) for name, spec in scene.mesh_bodies.items()}


def made_mesh(body: MeshedBody) -> Mesh:
    """Return the mesh of a body, which is made if its file is a geometry.

    Raises MeshingError: gmsh failed, or the mesh is not good enough; the message begins with the
    key.
    """
    with _named(body.name):
        return _mesh(body.request, body.name)


def described(body: MeshedBody, mesh: Mesh) -> MeshedBody:
    """Return a body with all that its mesh tells: places of interfaces, mass, roundness.

    Raises MeshingError: a turning body that is none of revolution, or an interface that can't be
    one.
    """
    from solidwhirl.meshing.imported.body import body_of_mesh

    if body.mass is not None:
        return body
    with _named(body.name):
        found = body_of_mesh(body.name, body.request, mesh, body.rigid_disks)
        lost = abs(found.volume_m3 / body.volume_m3 - 1.0)
        if mesh.sector is not None and lost > _LOST:
            raise MeshingError(
                f"the mesh has a volume of {found.volume_m3:.6g} m³, {100.0 * lost:.2g} % off "
                f"that of the geometry, {body.volume_m3:.6g} m³: take a smaller size_m or a larger "
                "around; if that does not help, the faces of the cut are not meshed as they are"
            )
        return found


def base_plan(
    body: Body | MeshedBody, level: str, top_speed: float, carried: Mapping[str, tuple[str, ...]]
) -> BodyPlan:
    """Return the plan of a body without what its level computes; `top_speed` in rad/s."""
    own = {i.name: carried[f"{body.name}.{i.name}"] for i in body.interfaces}
    used = {motion for motions in own.values() for motion in motions} | {"ux", "uy"}
    return BodyPlan(
        level=level,
        orders=(1, 0) if {"uz", "rz"} & used else (1,),
        components=tuple(m for m in MOTIONS if m in used),
        interface_components=own,
        maximum_speed_rad_s=top_speed,
    )


def mesh_plan(
    body: MeshedBody, top_speed: float, on: set[str], carried: Mapping[str, tuple[str, ...]]
) -> BodyPlan:
    """Plan a body from a mesh of its own, which is always a solid, all of it or one sector."""
    plan, shape = base_plan(body, "solid", top_speed, carried), body.request.shape
    prestressed = shape != "any" and "stress_stiffening" in on
    spins = prestressed and top_speed > 0.0
    return replace(
        plan,
        orders=plan.orders if shape in ("round", "cyclic") else (),
        # the error of a given mesh is not known
        resolution=Resolution(
            degree=2,
            size=MeshSize(size_m=body.longest_m, corner_size_m=body.shortest_m),
            expected_error=float("nan"),
        ),
        matrices=4 + prestressed,
        factorisations=1 + prestressed + spins,
        eigenproblems=1 + spins,
        shape=shape,
    )


def source_document(body: MeshedBody) -> dict[str, Any]:
    """Where a body comes from, its sectors, or how far it is from one of revolution, as data."""
    found = body.roundness
    return {
        "file": Path(body.request.path).name,
        "sha256": body.request.digest,
        "length_unit_m": body.request.unit_m,
        "sectors": body.request.sectors,
        "roundness": found
        and {
            "static_unbalance": found.static_unbalance,
            "uneven_mass": found.uneven_mass,
            "surface": found.surface,
        },
    }


@contextmanager
def _named(name: str) -> Iterator[None]:
    """Let the message of an error begin with the key of a body."""
    try:
        yield
    except (MeshingError, GeometryError) as error:
        raise type(error)(clean(f"mesh_bodies.{name}: {error}")) from error


def _built(scene: Scene, name: str, spec: MeshBodySpec) -> MeshedBody:
    with _named(name):
        request = _request(spec, scene_materials(scene))
        is_open = request.shape == "round" and spec.symmetry == "auto"
        if is_open and not _is_round(request, name):
            request = replace(request, shape="asymmetric")
        disks = tuple(RigidDisk(**d.model_dump()) for d in spec.rigid_disks)
        return _body(name, request, disks)


@lru_cache(maxsize=16)
def _is_round(request: MeshRequest, name: str) -> bool:
    """Whether the body of a request is one of revolution, asked several times by a command."""
    from solidwhirl.meshing.imported.body import is_round

    return is_round(_mesh(_coarse(request), name))


def _coarse(request: MeshRequest) -> MeshRequest:
    """A geometry with few elements, whose shape tells as well whether it is of revolution.

    However small the elements of a request are: elements rise at least with the square of 1/size.
    """
    from solidwhirl.meshing.imported.formats.step import step_geometry

    if request.step is None:
        return request
    cells = step_geometry(request).expected.cells
    factor = max(_COARSE, (cells / _COARSE_CELLS) ** 0.5)
    sizes = (factor * request.step.size_m, factor * request.step.smallest_m)
    around = max(request.step.around, _EDGES)
    return replace(request, step=StepSize(size_m=sizes[0], smallest_m=sizes[1], around=around))


@lru_cache(maxsize=16)
def _body(name: str, request: MeshRequest, disks: tuple[RigidDisk, ...]) -> MeshedBody:
    """The body of a request, which a command asks for several times."""
    from solidwhirl.meshing.imported.body import body_of_mesh

    if request.step is not None:
        return _unmeshed(name, request, disks)
    mesh = _mesh(request, name)
    _refuse_same_surfaces(mesh)
    remarks = read_mesh(request.path, request.digest).remarks
    return replace(body_of_mesh(name, request, mesh, disks), remarks=remarks)


def _mesh(request: MeshRequest, name: str) -> Mesh:
    """The mesh of a request, which does not depend on how the reduction takes it."""
    return _read_mesh(replace(request, shape="any"), name)


@lru_cache(maxsize=4)
def _read_mesh(request: MeshRequest, name: str) -> Mesh:
    """The mesh of a request; a command asks for it several times."""
    from solidwhirl.meshing.imported.body import mesh_of
    from solidwhirl.meshing.imported.formats.step import mesh_step

    if request.step is None:
        return mesh_of(read_mesh(request.path, request.digest), request, name)
    return mesh_of(mesh_step(request), request, name)


def _request(spec: MeshBodySpec, materials: dict[str, Material]) -> MeshRequest:
    step = None
    if spec.size_m is not None:
        smallest = spec.smallest_m or _SMALLEST * spec.size_m
        step = StepSize(size_m=spec.size_m, smallest_m=smallest, around=spec.around)
    return MeshRequest(
        path=spec.file,
        digest=spec.sha256 or content_digest(Path(spec.file)),
        unit_m=UNITS_M[spec.length_unit],
        origin=spec.axis.origin,
        direction=spec.axis.direction,
        x_direction=spec.axis.x_direction,
        material=known_material(materials, spec.material, "material") if spec.material else None,
        materials=tuple(
            (group, known_material(materials, name, f"materials.{group}"))
            for group, name in spec.materials.items()
        ),
        interfaces=tuple(_interface(i) for i in spec.interfaces),
        shape=_shape(spec),
        sectors=spec.sectors,
        mass_unit_kg=None if spec.mass_unit is None else MASSES_KG[spec.mass_unit],
        step=step,
        joints=tuple(Joint(**j.model_dump()) for j in spec.joints),
    )


def _shape(spec: MeshBodySpec) -> Shape:
    """What the reduction may assume, as far as the scene says."""
    if spec.sectors or spec.joints:
        return "cyclic"
    if spec.may_have_any_shape:
        return "any"
    return "asymmetric" if spec.symmetry == "none" else "round"


def _interface(spec: MeshInterfaceSpec) -> MeshInterface:
    return MeshInterface(
        name=spec.name,
        coupling=spec.coupling,
        group=spec.group,
        box_m=spec.box_m,
        node=spec.node if spec.node_m is None else spec.node_m,
    )


def _unmeshed(name: str, request: MeshRequest, disks: tuple[RigidDisk, ...]) -> MeshedBody:
    """A body whose mesh is to be made; the memory that it takes is known before."""
    from solidwhirl.meshing.imported.formats.step import step_geometry

    assert request.step is not None
    found = step_geometry(request)
    low, high = found.low_m, found.high_m
    diagonal = max(b - a for a, b in zip(low, high, strict=True))
    return MeshedBody(
        name=name,
        request=replace(request, joints=found.joints),
        interfaces=request.interfaces,
        rigid_disks=disks,
        expected=found.expected,
        shortest_m=request.step.smallest_m,
        longest_m=request.step.size_m,
        length_m=diagonal,
        radius_m=0.5 * sorted(b - a for a, b in zip(low, high, strict=True))[1],
        volume_m3=found.volume_m3,
    )


def _refuse_same_surfaces(mesh: Mesh) -> None:
    """Interfaces of one surface have the same motion: one is enough."""
    surfaces = {
        name: frozenset(map(tuple, facets[:, :3].tolist()))
        for name, facets in mesh.interfaces.items()
    }
    for first, second in combinations(surfaces, 2):
        if surfaces[first] == surfaces[second]:
            raise MeshingError(
                f"interfaces {first!r} and {second!r} are the same surface; keep one of them, any "
                "number of bearings and rigid disks may use it"
            )
