"""Stages of a run that are taken from a store where they are there, and kept where they are not."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Literal

from solidwhirl.beam_bodies import BeamBodies
from solidwhirl.body_reduction import Discretisation, Progress
from solidwhirl.dial import Round
from solidwhirl.geometry import Material
from solidwhirl.meshing import LocalSize, Mesh, MeshQuality, MeshSize
from solidwhirl.outcome import Outcome, Write, is_picture
from solidwhirl.rotordyn import Campbell, CriticalSpeed, Invariant, Modes, Superelement
from solidwhirl.rotordyn.branch_notes import TrackingNote
from solidwhirl.rotordyn.campbell_errors import CampbellErrors
from solidwhirl.rotordyn.critical_speed_errors import CriticalSpeedErrors
from solidwhirl.rotordyn.eigenvalue_errors import FrequencyErrors
from solidwhirl.rotordyn.mass_moments import MassMoments
from solidwhirl.rotordyn.stability import UnstableInterval
from solidwhirl.rotordyn.superelement import Coordinate, ErrorForm, InterfaceNode
from solidwhirl.rotordyn.surface import Surface
from solidwhirl.run_folder import writing_problem
from solidwhirl.scene import Scene
from solidwhirl.scene_imports import without_folders
from solidwhirl.scene_meshes import without_mesh_folders
from solidwhirl.store import FreshStore, StageStore
from solidwhirl.store_codec import fingerprint

Origin = Literal["computed", "kept"]
# Parts of a scene that no number of its engine depends on; analyses stand for themselves.
_WORDS = frozenset({"name", "title", "notes", "operating", "analyses", "references", "sweep"})


@dataclass(frozen=True, kw_only=True, eq=False)
class KeptReduction:
    """A superelement and what its reduction did, without its solver objects.

    Attributes
    ----------
    element
        The superelement.
    assembled, solved, orthogonality_error, hoop_strain, solver, seconds
        As in `solidwhirl.reduction.ReductionWork`.
    checks
        As in `solidwhirl.reduction.ReductionWork`.
    has_indicators
        Whether the reduction told where on the mesh its error arises.
    """

    element: Superelement
    assembled: Mapping[str, tuple[str, ...]]
    solved: Mapping[str, tuple[str, ...]]
    orthogonality_error: float
    hoop_strain: float
    solver: str
    seconds: Mapping[str, float]
    checks: tuple[Invariant, ...]
    has_indicators: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class KeptAnalysis:
    """An analysis with the content of its files.

    Attributes
    ----------
    kind, document, headline
        As in `Outcome`.
    files
        Names of its files in their order.
    data
        Content of those that are no pictures.
    """

    kind: str
    document: Mapping[str, Any]
    headline: str
    files: tuple[str, ...]
    data: Mapping[str, bytes]


_RECORDS = (
    BeamBodies,
    Campbell,
    CampbellErrors,
    Coordinate,
    CriticalSpeed,
    CriticalSpeedErrors,
    Discretisation,
    ErrorForm,
    FrequencyErrors,
    InterfaceNode,
    Invariant,
    KeptAnalysis,
    KeptReduction,
    LocalSize,
    MassMoments,
    Material,
    Mesh,
    MeshQuality,
    MeshSize,
    Modes,
    Round,
    Superelement,
    Surface,
    TrackingNote,
    UnstableInterval,
)
RECORDS: Mapping[str, type] = {kind.__name__: kind for kind in _RECORDS}


def open_store(folder: str | Path) -> StageStore:
    """Return the store of a folder; the folder is made when something is kept first."""
    return StageStore(folder, RECORDS)


def open_fresh_store(folder: str | Path) -> StageStore:
    """Return a store that keeps in a folder and looks for nothing in it."""
    return FreshStore(folder, RECORDS)


def engine_part(scene: Scene) -> dict[str, Any]:
    """The parts of a scene that numbers of its engine depend on, its analyses left out."""
    parts = {n: getattr(scene, n) for n in type(scene).model_fields if n not in _WORDS}
    # by content, wherever the files lie
    return {
        **parts,
        "imported": without_folders(scene.imported),
        "mesh_bodies": without_mesh_folders(scene.mesh_bodies),
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Keeper:
    """What a run asks for its stages.

    Attributes
    ----------
    store
        Where they are kept; None: nowhere.
    progress
        Told what is wrong with the store.
    origins
        Where each stage came from, filled as the run goes on; empty without a store.
    """

    store: StageStore | None
    progress: Progress
    origins: dict[str, Origin] = field(default_factory=dict)

    def key(self, stage: str, *parts: Any) -> str:
        """Key of a stage by what goes into it; nothing without a store."""
        return "" if self.store is None else self.store.key(stage, *parts)

    def digest(self, value: Any) -> str:
        """Key of a value that goes into several stages; nothing without a store."""
        return self.key("value", value)

    def same(self, first: Any, second: Any) -> bool:
        """Whether two values are the same; without a store only if they are one."""
        if first is second:
            return True
        return self.store is not None and fingerprint(first) == fingerprint(second)

    def find(self, key: str) -> Any | None:
        """What is kept under a key, or None."""
        return None if self.store is None else self.store.find(key, self.progress)

    def keep(self, key: str, stage: str, value: Any) -> None:
        """Keep a value."""
        if self.store is not None:
            self.store.keep(key, stage, value, self.progress)

    def alone(self, key: str) -> AbstractContextManager[None]:
        """Have a stage for this process alone, see `StageStore.alone`."""
        return nullcontext() if self.store is None else self.store.alone(key, self.progress)

    def say(self, stage: str, origin: Origin) -> None:
        """Write down where a stage came from; further ones of the same name are numbered."""
        if self.store is None:
            return
        name, number = stage, 1
        while name in self.origins:
            number += 1
            name = f"{stage} ({number})"
        self.origins[name] = origin

    def stage(self, name: str, key: str, compute: Callable[[], Any]) -> Any:
        """The value of a stage, kept or computed.

        Parameters
        ----------
        name
            Of the stage.
        key
            Of its inputs.
        compute
            Makes the value.
        """
        with self.alone(key):
            found = self.find(key)
            self.say(name, "computed" if found is None else "kept")
            if found is None:
                found = compute()
                self.keep(key, name, found)
        return found

    def analysis(self, label: str, title: str, key: str, compute: Callable[[], Outcome]) -> Outcome:
        """An analysis, kept or computed; its pictures are kept when they are drawn.

        Parameters
        ----------
        label, title
            Of the analysis, and what stands over its pictures.
        key
            Of its inputs.
        compute
            Runs it; called later where it is kept but a picture of it is not.
        """
        if self.store is None:
            return compute()
        name = f"analysis {label}"
        again = cache(compute)
        with self.alone(key):
            kept = self.find(key)
            self.say(name, "computed" if kept is None else "kept")
            if kept is None:
                kept = self._as_kept(name, again())
                if kept is None:
                    return again()
                self.keep(key, name, kept)

        def later(file: str) -> Write:
            return lambda path: again().files[file](path)

        files: dict[str, Write] = {}
        for file in kept.files:
            if file in kept.data:
                files[file] = _copy(kept.data[file])
            else:
                files[file] = self.picture(self.key("picture", key, title, file), later(file))
        return Outcome(kind=kept.kind, document=kept.document, files=files, headline=kept.headline)

    def _as_kept(self, name: str, outcome: Outcome) -> KeptAnalysis | None:
        """The analysis with the content of its data files; None where they can't be written."""
        assert self.store is not None
        data = {}
        try:
            self.store.folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=".writing-", dir=self.store.folder) as scratch:
                for file, write in outcome.files.items():
                    if not is_picture(file):
                        write(Path(scratch) / file)
                        data[file] = (Path(scratch) / file).read_bytes()
        except Exception as error:
            # libraries have their own errors for a full disk
            problem = writing_problem(self.store.folder)
            if problem is None and not isinstance(error, OSError):
                raise
            self.progress(f"{name} is not kept: {problem or error}")
            return None
        return KeptAnalysis(
            kind=outcome.kind,
            document=outcome.document,
            headline=outcome.headline,
            files=tuple(outcome.files),
            data=data,
        )

    def picture(self, key: str, draw: Write) -> Write:
        """A function that writes a picture, from the store or by drawing it.

        Each format of a picture is kept by itself: the ending of the file tells it.

        Parameters
        ----------
        key
            Of all that it shows.
        draw
            Draws it.
        """

        def write(path: Path) -> None:
            own = self.key("format of a picture", key, path.suffix)
            kept = self.find(own)
            if kept is None:
                draw(path)
                self.keep(own, path.name, path.read_bytes())
            else:
                path.write_bytes(kept)

        return write


def no_keeper() -> Keeper:
    """A keeper that keeps nothing."""
    return Keeper(store=None, progress=lambda text: None)


def _copy(data: bytes) -> Write:
    def write(path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)

    return write
