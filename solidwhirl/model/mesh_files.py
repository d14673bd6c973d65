"""Files of mesh bodies, read with the scene: their digest, reference nodes, masses on these."""

from __future__ import annotations

import hashlib
import re
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

from solidwhirl.core.errors import clean
from solidwhirl.core.machine import available_memory_gib
from solidwhirl.meshing import MeshingError
from solidwhirl.meshing.imported.records import FileCoupling, FileMesh, MeshRequest, on_axis
from solidwhirl.rotordyn.core.foreign import ForeignError, refuse_irregular
from solidwhirl.scene.meshes import (
    MASSES_KG,
    UNITS_M,
    MeshBodySpec,
    MeshInterfaceSpec,
    RigidDiskSpec,
    file_digest,
)
from solidwhirl.scene.records import Scene

if TYPE_CHECKING:
    from solidwhirl.meshing.imported.masses import CarriedMass

# Formats that have reference nodes and masses.
_WITH_PARTS = (".inp", ".bdf", ".nas", ".dat")
# Memory that reading a mesh takes over the size of its file.
_READING = 12.0
_GIB = 1024.0**3
_NO_NAME = re.compile(r"[^A-Za-z0-9_-]+")
_LONGEST_NAME = 64


def with_mesh_files_read(scene: Scene) -> tuple[Scene, list[str]]:
    """Read the files of mesh bodies.

    Returns the scene with `sha256`, with an interface for each rigid coupling, each that carries a
    mass, and each that the scene names, and with a rigid disk for each mass on a reference node;
    and problems, one line each, which begins with the key.
    """
    found, problems = {}, []
    text = scene.model_dump_json() if scene.mesh_bodies else ""
    for name, spec in scene.mesh_bodies.items():
        key = f"mesh_bodies.{name}"
        try:
            digest = content_digest(Path(spec.file))
            if spec.sha256 not in (None, digest):
                problems.append(
                    f"{key}.sha256: {Path(spec.file).name} has another content, {digest}; leave "
                    "the key out"
                )
            found[name] = spec.model_copy(update={"sha256": digest})
            if Path(spec.file).suffix.lower() in _WITH_PARTS:
                found[name] = _with_parts(name, found[name], text)
        except MeshingError as error:
            problems.append(clean(f"{key}.{error}"))
    if problems or not found:
        return scene, problems
    return scene.model_copy(update={"mesh_bodies": found}), []


def content_digest(path: Path) -> str:
    """SHA-256 of a file and those that it includes, which fit into memory when they are read.

    Raises MeshingError: it can't be read.
    """
    try:
        refuse_irregular(path)
        own = file_digest(path)
        if path.suffix.lower() not in _WITH_PARTS:
            return own
        included = read_mesh(str(path), own).files[1:]
        each = [own, *(file_digest(file) for file in included)]
    except ForeignError as error:
        raise MeshingError(f"file: {path}: {error}") from error
    except OSError as error:
        raise MeshingError(f"file: {path} can not be read: {error.strerror or error}") from error
    return own if len(each) == 1 else hashlib.sha256("".join(each).encode()).hexdigest()


@lru_cache(maxsize=4)
def read_mesh(path: str, digest: str) -> FileMesh:
    """Return what a mesh file holds; a command asks for it several times.

    `digest`: of its content, by which the answer is kept. Raises MeshingError: see
    `read_mesh_file`; or the file is too large for the memory that is available.
    """
    from solidwhirl.meshing.imported.formats.files import read_mesh_file

    size = Path(path).stat().st_size / _GIB
    if _READING * size > available_memory_gib():
        raise MeshingError(
            f"file: {Path(path).name} has {size:.3g} GiB; reading it takes about "
            f"{_READING * size:.3g} GiB of memory, {available_memory_gib():.3g} are available"
        )
    try:
        return read_mesh_file(path)
    except MeshingError as error:
        raise MeshingError(f"file: {error}") from error


def _with_parts(name: str, spec: MeshBodySpec, scene_text: str) -> MeshBodySpec:
    """The body with what its file says of reference nodes, unless the scene says it."""
    from solidwhirl.meshing.imported.groups import as_written
    from solidwhirl.meshing.imported.masses import carried_masses

    assert spec.sha256 is not None
    file = read_mesh(spec.file, spec.sha256)
    if not file.couplings:
        return spec
    request = MeshRequest(
        path=spec.file,
        digest=spec.sha256,
        unit_m=UNITS_M[spec.length_unit],
        origin=spec.axis.origin,
        direction=spec.axis.direction,
        x_direction=spec.axis.x_direction,
        material=None,
        shape="any" if spec.may_have_any_shape else "round",
        mass_unit_kg=None if spec.mass_unit is None else MASSES_KG[spec.mass_unit],
    )
    try:
        carried = carried_masses(file, request)
    except MeshingError as error:
        raise MeshingError(f"file: {Path(spec.file).name}: {error}") from error
    interfaces = list(spec.interfaces)
    loaded = {id(mass.coupling): "" for mass in carried}
    for coupling in file.couplings:
        own, names = _plain_name(coupling.name), [coupling.name, coupling.group]
        at = next(
            (
                k
                for k, i in enumerate(interfaces)
                if i.group and as_written(i.group, names) in names
            ),
            len(interfaces),
        )
        wanted = coupling.coupling == "rigid" or id(coupling) in loaded
        if at == len(interfaces):
            if not wanted and f'"{name}.{own}"' not in scene_text:
                continue
            interfaces.append(MeshInterfaceSpec(name=own, group=coupling.name))
        interfaces[at] = _at_reference(interfaces[at], coupling, file, request)
        if id(coupling) in loaded:
            loaded[id(coupling)] = interfaces[at].name
    disks = list(spec.rigid_disks)
    for mass in carried:
        disk = _disk(mass, loaded[id(mass.coupling)])
        disks += [disk] if disk.name not in {d.name for d in disks} else []
    return spec.model_copy(update={"interfaces": tuple(interfaces), "rigid_disks": tuple(disks)})


def _plain_name(text: str) -> str:
    """A name as scenes have them."""
    plain = _NO_NAME.sub("_", text).strip("_")
    return (plain if plain[:1].isalpha() else f"n_{plain}")[:_LONGEST_NAME]


def _at_reference(
    given: MeshInterfaceSpec, coupling: FileCoupling, file: FileMesh, request: MeshRequest
) -> MeshInterfaceSpec:
    """An interface that follows as its coupling says, its node the reference node.

    Of a body that turns the node is on the axis, at the same place along it.
    """
    update: dict[str, object] = {}
    if "coupling" not in given.model_fields_set:
        update["coupling"] = coupling.coupling
    if not given.model_fields_set & {"node", "node_m"}:
        place = [float(v) for v in on_axis(file.points[[coupling.node]], request)[0]]
        update["node_m"] = tuple(place if request.shape == "any" else (0.0, 0.0, place[2]))
    return given.model_copy(update=update)


def _disk(mass: CarriedMass, interface: str) -> RigidDiskSpec:
    return RigidDiskSpec(
        name=_plain_name(mass.label.split(" (", maxsplit=1)[0]),
        interface=interface,
        mass_kg=mass.mass_kg,
        polar_inertia_kg_m2=mass.polar_kg_m2,
        diametral_inertia_kg_m2=mass.diametral_kg_m2,
        offset_m=mass.offset_m,
    )
