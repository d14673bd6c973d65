"""The cases of a study: which settings of a scene are run, and the scenes that say so."""

from __future__ import annotations

import hashlib
import importlib.util
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from solidwhirl.bodies import build_bodies
from solidwhirl.geometry import GeometryError
from solidwhirl.interface_motions import places_of_joints
from solidwhirl.meshing import CORNER_RATE
from solidwhirl.scene import Scene
from solidwhirl.study_map import map_rows
from solidwhirl.study_matrix import Matrix
from solidwhirl.versions import package_versions

Group = Literal["reference", "mesh", "dial", "modes", "beam", "coupling", "beam_map"]
Setting = str | int | float | None
#: Changes with what a case stores or how it measures, so that older results are not taken.
CASE_SCHEMA = "solidwhirl-study-case-1"
_STAGES = (".geometry", ".meshing", ".reduction", ".rotordyn")
# Sources that no result of a case comes from, and exceptions.
_OTHERS = ("pictures", "picture_", "cli", "identify", "report", "study")
_MEASURING = ("study_case.py", "study_errors.py", "study_map.py", "study_measure.py")
# Mesh cases: the estimates' own comparison models follow this accuracy.
_FIXED_ACCURACY = 5e-3
# Sizes over the thinnest section: largest element, element at corners, uniform elements.
_LARGEST, _CORNER, _UNIFORM = 4.0, 0.3, 2.0
_SOLID_CORNER = 1.0
# One rung of the graded ladder divides the largest size by this.
_STEP = 2.0**0.5


@dataclass(frozen=True, kw_only=True)
class StudyCase:
    """One case: a scene with other settings, run in a process of its own.

    Attributes
    ----------
    name
        Unique in the study.
    group
        What it is compared with.
    level
        "beam", "harmonic" or "solid"; "" for a row of the map.
    ladder
        "graded", "uniform", "adaptive", "modes" or "profile"; cases of one level, order and ladder
        are fitted together. "" for those that are not.
    order
        Element order, None where it is chosen by the program.
    settings
        What differs from the scene, for the reader.
    payload
        What the process is told: plain data.
    """

    name: str
    group: Group
    level: str
    ladder: str
    order: int | None
    settings: Mapping[str, Setting]
    payload: Mapping[str, Any]

    @property
    def key(self) -> str:
        """SHA-256 of scene, settings and versions: cases with one key have one result."""
        content = {
            "schema": CASE_SCHEMA,
            "payload": self.payload,
            "versions": package_versions(),
            "program": program_digest(),
        }
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


@cache
def program_digest() -> str:
    """Return the SHA-256 of the sources that results come from, as they were at the first call.

    Versions alone would mix results from before and after a change of the program. Pictures, the
    command line, identification and what only reads results are left out.
    """
    found = [importlib.util.find_spec(f"solidwhirl{stage}") for stage in ("", *_STAGES)]
    folders = [Path(str(spec.origin)).parent for spec in found if spec is not None]
    content = hashlib.sha256()
    for path in (p for folder in folders for p in sorted(folder.glob("*.py"))):
        if path.name.startswith(_OTHERS) and path.name not in _MEASURING:
            continue
        content.update(path.name.encode() + path.read_bytes())
    return content.hexdigest()


def study_cases(scene: Scene, matrix: Matrix) -> tuple[StudyCase, ...]:
    """Return the cases of a study in the order they are run, the reference first.

    Parameters
    ----------
    scene
        Its analyses beyond Campbell diagram and critical speeds are left out, and so is the
        comparison of couplings, which has cases of its own.
    matrix
        `FULL` or `QUICK` of `solidwhirl.study_matrix`.
    """
    base = scene.model_copy(update={"analyses": ()})
    cases = [_reference(base, matrix), *_dial(base, matrix), _beam(base)]
    cases += _graded(base, matrix)
    cases += _uniform(base, matrix)
    cases += _modes(base, matrix)
    cases += _coupling(base) if matrix.coupling else []
    cases += _solid(base, matrix)
    for name in matrix.beam_maps:
        cases += _map(name, matrix.beam_map_side)
    return tuple(cases)


def _map(name: str, side: int) -> list[StudyCase]:
    return [
        StudyCase(
            name=f"beam map, {name}, row {k}",
            group="beam_map",
            level="",
            ladder="",
            order=None,
            settings={"map": name, row["y_name"]: row["y"]},
            payload={"kind": "map_row", **row},
        )
        for k, row in enumerate(map_rows(name, side), 1)
    ]


def case_scene(scene: Scene, **model: Any) -> Scene:
    """Return the scene with another [model] table; what is not named is free.

    Raises
    ------
    pydantic.ValidationError
        A value that a scene file could not have either.
    """
    bodies = {name: b.model_copy(update={"modes": None}) for name, b in scene.bodies.items()}
    table = type(scene.model).model_validate({"compare_coupling": "off", **model})
    return scene.model_copy(update={"model": table, "bodies": bodies})


def thinnest_m(scene: Scene) -> float:
    """Return the smallest dimension of all sections of all bodies, m: it sets the sizes."""
    found = []
    for body in build_bodies(scene).values():
        for s in body.sections:
            radial = [o - i for i, o in zip(s.inner_radius_m, s.outer_radius_m, strict=True)]
            found.append(min(s.end_m - s.start_m, max(radial)))
    return min(found)


def _run(scene: Scene, phases: str, *, margin: bool = False) -> dict[str, Any]:
    """Payload of a run: the scene as data, and what is measured.

    phases: "apart" runs without error estimates and then with them; "together" once with them.
    """
    data = scene.model_dump(mode="json", exclude_unset=True)
    return {"kind": "run", "scene": data, "phases": phases, "margin": margin}


def _reference(scene: Scene, matrix: Matrix) -> StudyCase:
    chosen = {"level": "harmonic", "accuracy": matrix.reference_accuracy}
    return StudyCase(
        name="reference",
        group="reference",
        level="harmonic",
        ladder="adaptive",
        order=None,
        settings={"accuracy": matrix.reference_accuracy},
        payload=_run(case_scene(scene, **chosen), "together", margin=True),
    )


def _dial(scene: Scene, matrix: Matrix) -> list[StudyCase]:
    return [
        StudyCase(
            name=f"harmonic, accuracy {accuracy:g}",
            group="dial",
            level="harmonic",
            ladder="adaptive",
            order=None,
            settings={"accuracy": accuracy},
            payload=_run(case_scene(scene, level="harmonic", accuracy=accuracy), "together"),
        )
        for accuracy in matrix.dial
    ]


def _beam(scene: Scene) -> StudyCase:
    return StudyCase(
        name="beam",
        group="beam",
        level="beam",
        ladder="profile",
        order=None,
        settings={},
        payload=_run(case_scene(scene, level="beam"), "apart"),
    )


def _meshed(scene: Scene, level: str, ladder: str, rung: str, **model: Any) -> StudyCase:
    chosen = case_scene(scene, level=level, accuracy=_FIXED_ACCURACY, **model)
    return StudyCase(
        name=f"{level}, order {model['order']}, {ladder}, {rung}",
        group="modes" if ladder == "modes" else "mesh",
        level=level,
        ladder=ladder,
        order=model["order"],
        settings=model,
        payload=_run(chosen, "apart"),
    )


def graded_sizes(thinnest: float, order: int, rung: int) -> dict[str, float]:
    """Return sizes of the graded ladder.

    Each rung divides largest size and growth by √2 and the size at corners by √2 to the power
    2p / 1.089, so that the error of the corners falls as fast as that of smooth fields would.

    Parameters
    ----------
    thinnest
        Smallest dimension of the bodies, m.
    order
        Element order p.
    rung
        Number of refinements.
    """
    factor = _STEP**-rung
    corner = _CORNER * thinnest * factor ** (2.0 * order / CORNER_RATE)
    return {
        "size_m": _LARGEST * thinnest * factor,
        "corner_size_m": max(corner, 1e-5 * thinnest),
        "growth": factor,
    }


def _graded(scene: Scene, matrix: Matrix) -> list[StudyCase]:
    thinnest, modes = thinnest_m(scene), matrix.ladder_modes
    return [
        _meshed(scene, "harmonic", "graded", f"rung {rung}", order=order, modes=modes,
                **graded_sizes(thinnest, order, rung))
        for order, rungs in matrix.graded_rungs.items()
        for rung in rungs
    ]  # fmt: skip


def _uniform(scene: Scene, matrix: Matrix) -> list[StudyCase]:
    thinnest, modes = thinnest_m(scene), matrix.ladder_modes
    cases = []
    for order, rungs in matrix.uniform_rungs.items():
        for rung in rungs:
            size = _UNIFORM * thinnest * 0.5**rung
            sizes = {"size_m": size, "corner_size_m": size, "growth": 1.0}
            cases.append(
                _meshed(scene, "harmonic", "uniform", f"rung {rung}", order=order, modes=modes,
                        **sizes)
            )  # fmt: skip
    return cases


def _solid(scene: Scene, matrix: Matrix) -> list[StudyCase]:
    thinnest = thinnest_m(scene)
    return [
        _meshed(scene, "solid", "graded", f"sizes times {factor:g}", order=2,
                modes=matrix.solid_modes, size_m=_LARGEST * thinnest * factor,
                corner_size_m=_SOLID_CORNER * thinnest * factor, growth=0.8)
        for factor in matrix.solid_factors
    ]  # fmt: skip


def _modes(scene: Scene, matrix: Matrix) -> list[StudyCase]:
    order = matrix.modes_order
    sizes = graded_sizes(thinnest_m(scene), order, matrix.modes_rung)
    return [
        _meshed(scene, "harmonic", "modes", f"{modes} modes", order=order, modes=modes, **sizes)
        for modes in matrix.modes
    ]


def _coupling(scene: Scene) -> list[StudyCase]:
    """Both couplings of the interfaces that joints act on; none where there is no choice."""
    cases = []
    for coupling in ("distributing", "rigid"):
        changed, places = _coupled(scene, coupling)
        if not places:
            return []
        chosen = case_scene(changed, level="harmonic", accuracy=1e-3)
        cases.append(
            StudyCase(
                name=f"coupling {coupling}",
                group="coupling",
                level="harmonic",
                ladder="",
                order=None,
                settings={"coupling": coupling, "interfaces": ", ".join(places), "accuracy": 1e-3},
                payload=_run(chosen, "together"),
            )
        )
    return cases


def _coupled(scene: Scene, coupling: str) -> tuple[Scene, list[str]]:
    """The scene with one coupling, and the interfaces that can have it."""
    joints, places, bodies = places_of_joints(scene), [], dict(scene.bodies)
    for name, spec in scene.bodies.items():
        for k, interface in enumerate(spec.interfaces):
            if f"{name}.{interface.name}" not in joints:
                continue
            own = list(bodies[name].interfaces)
            own[k] = interface.model_copy(update={"coupling": coupling})
            tried = {**bodies, name: bodies[name].model_copy(update={"interfaces": tuple(own)})}
            try:
                build_bodies(scene.model_copy(update={"bodies": tried}))
            except GeometryError:
                continue  # its kind has but one coupling
            bodies = tried
            places.append(f"{name}.{interface.name}")
    return scene.model_copy(update={"bodies": bodies}), places
