"""Speed laws that a scene takes from files of the bearings' makers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pydantic import ValidationError

from solidwhirl import bearing_tables as files
from solidwhirl.bearing_tables.records import CoefficientTable, TableFileError
from solidwhirl.core.errors import Problem
from solidwhirl.scene.joints import (
    FileLawSpec,
    FrequencyTableLawSpec,
    LoadTableLawSpec,
    SpeedLawSpec,
    TableLawSpec,
)
from solidwhirl.scene.records import Scene


def with_laws_read(scene: Scene) -> tuple[Scene, list[str]]:
    """Put the tables of their files in the place of the laws of `kind = "file"`.

    What depends on the scene then depends on the content of the files, wherever they lie. Returns
    the scene and problems, one line each, which begins with the key.
    """
    laws: dict[str, SpeedLawSpec] = dict(scene.speed_laws)
    problems: list[str] = []
    for name, spec in scene.speed_laws.items():
        if not isinstance(spec, FileLawSpec):
            continue
        path = ("speed_laws", name)
        try:
            laws[name] = table_law(spec)
        except TableFileError as error:
            problems.append(Problem(f"speed_laws.{name}.file: {error}", (*path, "file")))
        except ValidationError as error:
            said = [f"{'.'.join(map(str, e['loc']))}: {e['msg']}" for e in error.errors()]
            text = f"speed_laws.{name}.file: {spec.file}: the table in it: {said[0]}"
            problems.append(Problem(text, (*path, "file")))
    return scene.model_copy(update={"speed_laws": laws}), problems


def table_law(spec: FileLawSpec) -> TableLawSpec | FrequencyTableLawSpec | LoadTableLawSpec:
    """Return the table in the file of a law, at its load and in the axes of the scene.

    Raises TableFileError: the file or a key is refused; pydantic.ValidationError: a table that a
    scene could not have either.
    """
    found = files.over(files.read_table(Path(spec.file), spec.tag), spec.axis)
    ours = files.turned(files.in_sense_of_spin(found, spec.maker_spin), spec.turned_deg)
    if spec.load_from is None:
        one = next(_records([files.at_load(ours, spec.load_n)], spec.interpolation))
        return one.assuming(ours.assumed)
    loads = () if ours.loads_n is None else tuple(ours.loads_n.tolist())
    if len(loads) < 2:
        many = "one load" if loads else "no column of loads"
        raise TableFileError(ours.source, f"load_from: the table has {many}")
    tables = tuple(_records([files.at_load(ours, n) for n in loads], spec.interpolation))
    over_load = LoadTableLawSpec(
        kind="load_table", load_from=spec.load_from, load_n=loads, tables=tables
    )
    return over_load.assuming(ours.assumed)


def _records(
    tables: Sequence[CoefficientTable], interpolation: str
) -> Iterator[TableLawSpec | FrequencyTableLawSpec]:
    """Tables of single loads, all of one kind."""
    laws = [files.as_table_law(table) for table in tables]
    over_frequency = any(law["kind"] == "frequency_table" for law in laws)
    kind = "frequency_table" if over_frequency else "table"
    record = FrequencyTableLawSpec if over_frequency else TableLawSpec
    for law in laws:
        yield record.model_validate({**law, "kind": kind, "interpolation": interpolation})
