"""The identification problem: what is free, what is wanted, checked against its scene."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError

from solidwhirl.core.errors import SceneError, repeated
from solidwhirl.core.fields import Count, Finite, Name, Note, NotNegative, Title
from solidwhirl.identify.rows import Rows, rows_of
from solidwhirl.identify.targets import (
    ProblemRecord,
    TargetSpec,
    data_problems,
    is_mass_target,
    is_measured,
    target_problems,
)
from solidwhirl.scene_reading.paths import Place, PlaceError, choice, find_place, with_values
from solidwhirl.scene_reading.reader import explained, load_toml, parse_scene

#: Significant digits of every value that is tried, and of those that are written.
DIGITS = 7
# Decimals of values that follow from parameters: cuts round-off, keeps the digits of a length.
_DECIMALS = 10
# Entries of a list.
_MOST = 1000
PlaceText = Annotated[str, Field(max_length=300)]


class ParameterSpec(ProblemRecord):
    """A number that is free within bounds; it may stand in several places of the scene."""

    name: Name
    lower: Finite
    upper: Finite
    start: Finite
    places: Annotated[tuple[PlaceText, ...], Field(max_length=_MOST)] = ()
    why: Title = ""


class DerivedSpec(ProblemRecord):
    """Places whose number is constant + Σ factor · parameter."""

    places: Annotated[tuple[PlaceText, ...], Field(min_length=1, max_length=_MOST)]
    terms: Annotated[dict[Name, Finite], Field(min_length=1)]
    constant: Finite = 0.0


class SettingsSpec(ProblemRecord):
    """How the search goes."""

    accuracy: Annotated[float, Field(ge=1e-5, le=0.1, strict=True)] = 1e-3
    coarse_accuracy: Annotated[float, Field(ge=1e-5, le=0.1, strict=True)] = 2e-2
    starts: Annotated[Count, Field(le=100)] = 1
    seed: Annotated[int, Field(ge=0, strict=True)] = 1
    step: Annotated[float, Field(ge=1e-4, le=0.2, strict=True)] = 2e-2
    prior: NotNegative = 0.1
    maximum_evaluations: Annotated[Count, Field(le=100_000)] = 500


class ProblemSpec(ProblemRecord):
    """A whole problem file."""

    name: Name
    scene: Title
    title: Title = ""
    notes: Annotated[tuple[Note, ...], Field(max_length=_MOST)] = ()
    settings: SettingsSpec = SettingsSpec()
    parameters: Annotated[tuple[ParameterSpec, ...], Field(min_length=1, max_length=_MOST)]
    derived: Annotated[tuple[DerivedSpec, ...], Field(max_length=_MOST)] = ()
    targets: Annotated[tuple[TargetSpec, ...], Field(min_length=1, max_length=_MOST)]
    comments: dict[PlaceText, Title] = Field(default_factory=dict, max_length=_MOST)


@dataclass(frozen=True, kw_only=True, eq=False)
class Problem:
    """A checked problem."""

    path: Path  # the problem file
    spec: ProblemSpec
    scene: Mapping[str, Any]  # content of its scene file
    places: Mapping[str, Place]  # every place named in the file, by its text

    @property
    def folder(self) -> Path:
        """Where files that the scene names are looked for."""
        return (self.path.parent / self.spec.scene).parent

    @cached_property
    def rows(self) -> Rows:
        """Numbers that the targets want."""
        return rows_of(self.spec.targets)

    @property
    def is_measured(self) -> bool:
        """Whether the targets are measurements with their uncertainty."""
        return is_measured(self.spec.targets)

    @property
    def prior(self) -> float:
        """Weight of the pull towards the starts; measurements decide alone."""
        return 0.0 if self.is_measured else self.spec.settings.prior

    @property
    def needs_model(self) -> bool:
        """Whether a target needs more than closed-form mass properties."""
        return not all(map(is_mass_target, self.spec.targets))

    def numbers(self, values: Mapping[str, float]) -> dict[Place, float]:
        """Return the number at every place for values of the parameters, by name."""
        found = {}
        for parameter in self.spec.parameters:
            for text in parameter.places:
                found[self.places[text]] = values[parameter.name]
        for derived in self.spec.derived:
            total = derived.constant + sum(f * values[n] for n, f in derived.terms.items())
            for text in derived.places:
                found[self.places[text]] = round(total, _DECIMALS)
        return found

    def scene_at(self, values: Mapping[str, float]) -> dict[str, Any]:
        """Return the content of the scene file for values of the parameters, by name."""
        return with_values(self.scene, self.numbers(values))

    @property
    def fingerprint(self) -> str:
        """SHA-256 of problem and scene; places that are overwritten do not count."""
        start = {p.name: p.start for p in self.spec.parameters}
        content = [self.spec.model_dump(mode="json"), self.scene_at(start)]
        return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def read_problem(path: str | Path) -> Problem:
    """Read and check an identification problem and its scene.

    `path`: a TOML file; the path of its scene is relative to it.
    Raises SceneError: a file can't be read, is not TOML, or holds something that it may not; all
    problems of a file at once.
    """
    path = Path(path)
    data = load_toml(path)
    try:
        spec = ProblemSpec.model_validate(data)
    except ValidationError as error:
        raise SceneError(path, explained(error, ProblemSpec)) from error
    scene_path = path.parent / spec.scene
    if (
        scene_path.exists() and not scene_path.is_file()
    ):  # a device or pipe that a file names would be waited for
        raise SceneError(path, [f"scene: {spec.scene!r} is no file ({scene_path})"])
    scene = load_toml(scene_path)
    ends = parse_scene(scene, scene_path).places()
    places: dict[str, Place] = {}
    problems = [*_parameter_problems(spec), *_place_problems(spec, scene, places)]
    problems += target_problems(spec.targets, list(scene.get("bodies", {})), ends)
    prior_is_set = "prior" in spec.settings.model_fields_set and spec.settings.prior > 0.0
    problems += data_problems(spec.targets, len(spec.parameters), prior_is_set)
    if problems:
        raise SceneError(path, problems)
    problem = Problem(path=path, spec=spec, scene=scene, places=places)
    start = {p.name: p.start for p in spec.parameters}
    parse_scene(problem.scene_at(start), f"{path}: the scene at the start", folder=problem.folder)
    return problem


def _parameter_problems(spec: ProblemSpec) -> Iterator[str]:
    known = [p.name for p in spec.parameters]
    yield from repeated("parameters", known)
    used = {n for d in spec.derived for n in d.terms}
    for k, p in enumerate(spec.parameters):
        where = f"parameters[{k}]"
        if not p.lower < p.upper:
            yield f"{where}.upper: {p.upper:g} is not above lower = {p.lower:g} ({p.name})"
        elif not p.lower <= p.start <= p.upper:
            yield (
                f"{where}.start: {p.start:g} lies outside the bounds {p.lower:g} to {p.upper:g} "
                f"({p.name})"
            )
        if not p.places and p.name not in used:
            yield f"{where}.places: {p.name!r} stands nowhere in the scene, and in no derived terms"
    for k, d in enumerate(spec.derived):
        for name in d.terms:
            if name not in known:
                yield f"derived[{k}].terms: no parameter {name!r}; {choice(name, known)}"
    s = spec.settings
    if s.coarse_accuracy < s.accuracy:
        yield (
            f"settings.coarse_accuracy: {s.coarse_accuracy:g} is finer than accuracy = "
            f"{s.accuracy:g}; the coarse search comes first"
        )


def _place_problems(
    spec: ProblemSpec, scene: Mapping[str, Any], places: dict[str, Place]
) -> Iterator[str]:
    """Find all places, and name those that are none or that two entries want to fill."""
    filled: dict[tuple[str | int, ...], str] = {}
    groups = [(f"parameters[{k}].places", p.places) for k, p in enumerate(spec.parameters)]
    groups += [(f"derived[{k}].places", d.places) for k, d in enumerate(spec.derived)]
    for where, texts in groups:
        for text in texts:
            try:
                places[text] = find_place(scene, text)
            except PlaceError as error:
                yield f"{where}: {error}"
                continue
            first = filled.setdefault(places[text].steps, where)
            if first != where or texts.count(text) > 1:
                yield f"{where}: {text!r} is filled by {first} already; a place has one value"
    for text in spec.comments:
        try:
            places[text] = find_place(scene, text)
        except PlaceError as error:
            yield f"comments: {error}"
