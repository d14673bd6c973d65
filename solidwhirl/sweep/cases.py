"""The cases of a batch: one for each plain scene, many for a scene with `[sweep]`."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from solidwhirl.core.errors import SceneError
from solidwhirl.core.fields import FileName, alike_in_files
from solidwhirl.scene.records import Scene
from solidwhirl.scene.sweep import SweepSpec
from solidwhirl.scene_reading.paths import Steps, entries_at, find_target, with_entries
from solidwhirl.scene_reading.reader import load_toml, parse_scene, scene_hash, with_model
from solidwhirl.sweep.records import BatchCase, Value
from solidwhirl.sweep.samples import sweep_values

_FOLDER_NAME: TypeAdapter[str] = TypeAdapter(FileName)


def batch_cases(
    paths: Sequence[str | Path], *, level: str | None = None, accuracy: float | None = None
) -> tuple[BatchCase, ...]:
    """Return the cases of scene files, in the order of the files and of their sweeps.

    `paths`: scene files, with `[sweep]` or without. `level`, `accuracy`: what replaces the level
    and accuracy of all scenes; None: nothing does.
    Raises SceneError: a file is refused, or all cases of its sweep are; two cases would have one
    name; an option replaces what a sweep varies. A single case that is refused is a case like the
    others: it fails when its turn comes.
    """
    cases: list[BatchCase] = []
    owners: dict[str, Path] = {}
    for path in map(Path, paths):
        found = _cases_of(path, level, accuracy)
        for case in found:
            _refuse_name(case, owners)
        cases += found
    alike = alike_in_files(list(owners))
    if alike:
        raise SceneError(
            owners[alike[1]],
            [f"name: {alike[1]!r} and {alike[0]!r} of {owners[alike[0]]} are one folder's name"],
        )
    return tuple(cases)


def case_scene(
    case: BatchCase, *, level: str | None = None, accuracy: float | None = None
) -> Scene:
    """Return the scene of a case.

    Raises SceneError: the values of the case make no scene.
    """
    where = f"{case.scene_path}: case {case.name}"
    scene = parse_scene(dict(case.data), where, folder=case.scene_path.parent)
    try:
        return with_model(scene, level=level, accuracy=accuracy)
    except ValidationError as error:
        said = str(error.errors()[0]["msg"]).removeprefix("Value error, ")
        raise SceneError(where, [f"model: {said}"]) from error


def _cases_of(path: Path, level: str | None, accuracy: float | None) -> list[BatchCase]:
    """Cases of one file."""
    data = load_toml(path)
    scene = parse_scene(data, path)
    options: dict[str, Any] = {"level": level, "accuracy": accuracy}
    if scene.sweep is None:
        case = _case(scene.name, path, {}, data, options)
        case_scene(case, **options)  # an option that the scene can not have
        return [case]
    base = {key: value for key, value in data.items() if key != "sweep"}
    _refuse_options(path, base, scene.sweep, options)
    return _checked(path, list(_swept(path, scene, base, options)), options)


def _swept(
    path: Path, scene: Scene, base: Mapping[str, Any], options: Mapping[str, Any]
) -> Iterator[BatchCase]:
    assert scene.sweep is not None
    everything = sweep_values(scene.sweep)
    for number, values in enumerate(everything, 1):
        entries: dict[Steps, Any] = {}
        for parameter in scene.sweep.parameters:
            entries |= entries_at(base, parameter, values[parameter.name])
        data = with_entries(base, entries)
        case = _case(f"{scene.name}-{number:04d}", path, values, data, options)
        yield replace(case, method=scene.sweep.method, sweep_cases=len(everything))


def _case(
    name: str,
    path: Path,
    values: Mapping[str, Value],
    data: Mapping[str, Any],
    options: Mapping[str, Any],
) -> BatchCase:
    case = BatchCase(name=name, scene_path=path, values=values, data=data, digest="")
    try:
        digest = scene_hash(case_scene(case, **options))
    except SceneError as error:
        # what is refused is told from others by its data and the reason
        content = json.dumps([data, dict(options), error.problems], sort_keys=True, default=str)
        digest = hashlib.sha256(content.encode("utf-8", "backslashreplace")).hexdigest()
    return replace(case, digest=digest)


def _checked(path: Path, cases: list[BatchCase], options: Mapping[str, Any]) -> list[BatchCase]:
    """The cases, if one of them at least makes a scene; else the sweep itself is wrong."""
    first: SceneError | None = None
    for case in cases:
        try:
            case_scene(case, **options)
        except SceneError as error:
            first = first or error
            continue
        return cases
    assert first is not None
    said = ", ".join(f"{name} = {value!r}" for name, value in cases[0].values.items())
    problems = [f"sweep: no case makes a scene; {cases[0].name} ({said}): {first.problems[0]}"]
    raise SceneError(path, problems) from first


def _refuse_options(
    path: Path, base: Mapping[str, Any], sweep: SweepSpec, options: Mapping[str, Any]
) -> None:
    """Options replace a key in all cases: a sweep over it would compute the same again."""
    for k, parameter in enumerate(sweep.parameters):
        for text in parameter.places:
            steps = find_target(base, text).steps
            key = str(steps[-1])
            if len(steps) == 2 and steps[0] == "model" and options.get(key) is not None:
                problem = f"sweep.parameters[{k}].places: --{key} replaces {text!r}; leave one out"
                raise SceneError(path, [problem])


def _refuse_name(case: BatchCase, owners: dict[str, Path]) -> None:
    """Each case has a folder of its name."""
    if not case.values:
        try:
            _FOLDER_NAME.validate_python(case.name)
        except ValidationError as error:
            said = str(error.errors()[0]["msg"]).removeprefix("Value error, ")
            raise SceneError(case.scene_path, [f"name: {said}"]) from error
    first = owners.setdefault(case.name, case.scene_path)
    if first is not case.scene_path:
        problem = f"name: a case of {first} is named {case.name!r} too, and each has a folder"
        raise SceneError(case.scene_path, [problem])
