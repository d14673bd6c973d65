"""Bodies that come from files: reading them with the scene, and their superelements."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from solidwhirl.model.plan_records import Plan
from solidwhirl.rotordyn.core.errors import SuperelementError
from solidwhirl.scene.imports import NATIVE, ImportedSpec
from solidwhirl.scene.meshes import file_digest
from solidwhirl.scene.records import Scene
from solidwhirl.scene_checks.interface_motions import EFFECT_OF, motions_acted_on

if TYPE_CHECKING:  # a scene without such bodies loads no reader
    from solidwhirl.rotordyn import Superelement
    from solidwhirl.rotordyn.exchange.matrices.foreign_body import ForeignBody

_ROLES = ("mass", "stiffness", "gyroscopic", "stress_stiffening", "spin_softening")
_FORMATS = {".npz": "npz", ".json": "Matrix Market", ".op4": "OUTPUT4", NATIVE: "superelement"}


def with_files_read(scene: Scene) -> tuple[Scene, list[str]]:
    """Read the files of imported bodies: their digest, and the interfaces where none are named.

    Returns the scene with `sha256`, and with `interfaces` by the numbers of nodes, or by the names
    in a superelement file; and problems, one line each, which begins with the key.
    """
    found, problems = {}, []
    for name, spec in scene.imported.items():
        where = f"imported.{name}"
        try:
            found[name] = _resolved(spec)
        except SuperelementError as error:
            problems.append(f"{where}.file: {error}")
        except _SpecError as error:
            problems.append(f"{where}.{error}")
    if problems or not found:
        return scene, problems
    return scene.model_copy(update={"imported": found}), []


class _SpecError(ValueError):
    """A key that does not fit the file."""


def _resolved(spec: ImportedSpec) -> ImportedSpec:
    from solidwhirl.rotordyn import read_superelement

    path = Path(spec.file)
    if path.suffix.lower() == NATIVE:
        files: tuple[Path, ...] = (path,)
        known = {node.name: node.name for node in read_superelement(path).interfaces}
        interfaces = spec.interfaces or known
        for key, node in interfaces.items():
            if node not in known:
                raise _SpecError(f"interfaces.{key}: no {node!r}; the file has {_list(known)}")
    else:
        body = _foreign(spec)
        files = body.files
        interfaces = _numbered(spec, body)
    digest = _digest(files)
    if spec.sha256 not in (None, digest):
        raise _SpecError(
            f"sha256: the content of {path.name} and what it names has {digest}, not this one"
        )
    return spec.model_copy(update={"sha256": digest, "interfaces": interfaces})


def _numbered(spec: ImportedSpec, body: ForeignBody) -> dict[str, int]:
    """Nodes of the interfaces by number; those with a name in the file if the scene gives none."""
    by_name = {name: number for number, name in body.names.items()}
    if not spec.interfaces:
        if not by_name:
            raise _SpecError(
                "interfaces: missing; the file has no names of nodes, give them as { mount = 101 }"
            )
        return by_name
    out = {}
    for key, node in spec.interfaces.items():
        if isinstance(node, str) and node not in by_name:
            known = _list(by_name) if by_name else "no names, only numbers"
            raise _SpecError(f"interfaces.{key}: no node {node!r}; the file has {known}")
        out[key] = by_name[node] if isinstance(node, str) else int(node)
        if out[key] not in body.positions:
            known = _list(body.positions)
            raise _SpecError(f"interfaces.{key}: no node {out[key]}; the file has {known}")
    return out


def _list(names: Mapping[str, object] | Mapping[int, object]) -> str:
    return ", ".join(str(name) for name in list(names)[:20])


def _foreign(spec: ImportedSpec) -> ForeignBody:
    from solidwhirl.rotordyn.exchange.matrices.arrays_npz import read_npz
    from solidwhirl.rotordyn.exchange.matrices.dmig import read_dmig
    from solidwhirl.rotordyn.exchange.matrices.matrix_market import read_matrix_market
    from solidwhirl.rotordyn.exchange.matrices.op4 import read_op4

    path = Path(spec.file)
    nodes = None if spec.nodes is None else Path(spec.nodes)
    suffix = path.suffix.lower()
    if suffix == ".op4":
        return read_op4(path, nodes)
    if nodes is not None and suffix in (".npz", ".json"):
        raise _SpecError(f"nodes: {path.name} has its own nodes; leave it out")
    if suffix == ".npz":
        return read_npz(path)
    if suffix == ".json":
        return read_matrix_market(path)
    return read_dmig(path, nodes)


def files_of(spec: ImportedSpec) -> tuple[Path, ...]:
    """Return all files of an imported body, those that its file names or includes too.

    Raises SuperelementError: they are no body.
    """
    native = Path(spec.file).suffix.lower() == NATIVE
    return (Path(spec.file),) if native else _foreign(spec).files


def _digest(files: tuple[Path, ...]) -> str:
    """SHA-256 of the content of files; of one file its own."""
    each = []
    for file in files:
        try:
            each.append(file_digest(file))
        except OSError as error:
            raise SuperelementError(f"{file}: can not be read: {error.strerror}") from error
    return each[0] if len(each) == 1 else hashlib.sha256("".join(each).encode()).hexdigest()


def imported_element(name: str, spec: ImportedSpec) -> Superelement:
    """Return the superelement of an imported body that was read, whatever the scene's effects.

    Raises SuperelementError: matrices that can't be a body, or files that have changed since the
    scene was read.
    """
    try:
        return _built(name, spec.model_dump_json())
    except SuperelementError as error:
        raise SuperelementError(f"imported.{name}: {error}") from error


@lru_cache(maxsize=16)
def _built(name: str, text: str) -> Superelement:
    """The superelement; the text of its entry holds the digest of its files."""
    from solidwhirl.rotordyn.importing.element import imported_superelement
    from solidwhirl.rotordyn.importing.rows import ImportOptions

    spec = ImportedSpec.model_validate_json(text)
    path = Path(spec.file)
    provenance = {
        "file": path.name,
        "format": _FORMATS.get(path.suffix.lower(), "DMIG"),
        "sha256": spec.sha256,
        "entry": spec.model_dump(
            mode="json", exclude={"file", "nodes", "sha256"}, exclude_defaults=True
        ),
    }
    if path.suffix.lower() == NATIVE:
        element = _native(name, spec, provenance)
        files: tuple[Path, ...] = (path,)
    else:
        body = _foreign(spec)
        files = body.files
        options = ImportOptions(
            interfaces=dict(spec.interfaces),
            names={role: n for role in _ROLES if (n := getattr(spec, role)) is not None},
            length_unit=spec.length_unit,
            mass_unit=spec.mass_unit,
            axes=spec.axes,
            origin_m=spec.origin_m,
            turns=spec.speed_ratio != 0.0,
        )
        element = imported_superelement(name, body, options, provenance)
    if _digest(files) != spec.sha256:
        raise SuperelementError(f"{path}: has changed since the scene was read; start again")
    return element


def _native(name: str, spec: ImportedSpec, provenance: Mapping[str, object]) -> Superelement:
    """A superelement file as a body; its level and what is known of its errors stay."""
    from solidwhirl.rotordyn import read_superelement
    from solidwhirl.rotordyn.importing.moved_element import (
        renamed_superelement,
        shifted_superelement,
    )

    found = read_superelement(spec.file)
    if spec.speed_ratio != 0.0 and not found.gyroscopic.any():
        raise SuperelementError(
            f"{spec.file}: the body turns (speed_ratio is not 0) and was reduced without a "
            "gyroscopic matrix; reduce it with effects.gyroscopic on"
        )
    moved = shifted_superelement(
        renamed_superelement(found, name, {k: str(v) for k, v in spec.interfaces.items()}),
        spec.origin_m,
    )
    return replace(moved, provenance={**found.provenance, "import": dict(provenance)})


def imported_elements(scene: Scene, plan: Plan) -> dict[str, Superelement]:
    """Return the superelements of the imported bodies of a scene, without effects that are off.

    Raises SuperelementError: a body that can't be, or an interface without a motion that something
    acts on.
    """
    out = {}
    for name, spec in scene.imported.items():
        element = imported_element(name, spec)
        for problem in _missing_motions(scene, plan, name, element):
            raise SuperelementError(problem)
        zero = np.zeros((element.size,) * 2)
        if not plan.on("gyroscopic") and element.gyroscopic.any():
            element = replace(element, gyroscopic=zero)
        if not plan.on("stress_stiffening") and element.stress_stiffening.any():
            element = replace(element, stress_stiffening=zero, spin_softening=zero)
        out[name] = element
    return out


def _missing_motions(scene: Scene, plan: Plan, name: str, element: Superelement) -> Iterator[str]:
    for place, pairs in motions_acted_on(scene).items():
        body, _, interface = place.partition(".")
        if body != name:
            continue
        has = element.components_at(interface)
        for motion, why in pairs:
            if plan.on(EFFECT_OF[motion]) and motion not in has:
                yield (
                    f"imported.{name}: interface {interface!r} has no {motion}, which {why!r} acts "
                    f"on; the file gives it {', '.join(has)}"
                )
