"""Reading a scene file, with messages that name file, key, finding and what is allowed."""

from __future__ import annotations

import hashlib
import re
import tomllib
import types
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from solidwhirl.analyses.base import Analysis
from solidwhirl.analyses.registry import KINDS
from solidwhirl.core.errors import KeyPath, Problem, SceneError, clean, meant
from solidwhirl.core.fields import keys_of
from solidwhirl.core.toml_text import KEY, LONG_KEY, long_key
from solidwhirl.model.imported_bodies import with_files_read
from solidwhirl.model.mesh_files import with_mesh_files_read
from solidwhirl.rotordyn.core.foreign import ForeignError, regular_bytes
from solidwhirl.scene.records import Scene, analyses_without_folders, without_folders
from solidwhirl.scene.sweep import sweep_problems
from solidwhirl.scene_reading.law_files import with_laws_read
from solidwhirl.scene_reading.paths import place_problems
from solidwhirl.scene_reading.references import reference_problems
from solidwhirl.scene_reading.toml_places import last_token

_MAXIMUM_BYTES = 4_000_000
_MAXIMUM_PROBLEMS = 100
_TOML_WORDS = {"tuple": "array", "Tuple": "Array", "dictionary": "table", "Dictionary": "Table"}
_BARE_KEY = re.compile(r"[\w-]{1,64}")
_BYTE_ORDER_MARK = "\ufeff"
# Where tomllib says that an error is.
_AT, _AT_END = re.compile(r" ?\(at line (\d+), column (\d+)\)$"), " (at end of document)"
# What it says behind the whole part of a number with a decimal comma, and the text there.
_BEHIND_NUMBER = (
    ("Expected newline or end of document", re.compile(r"\d$"), re.compile(r",\d")),
    ("Expected '=' after a key", re.compile(r"\d,\d[\w+-]*\s*$"), re.compile("")),
)
_COMMA = "; a decimal point is wanted, not a comma"
# What it says where neither a comma nor the closing bracket follows a value.
_NO_KEY = "Invalid initial character for a key part"
_UNCLOSED = {"Unclosed array": "]", "Unclosed inline table": "}"}
# A line that can only begin a table or assign a key.
_NEXT_LINE = re.compile(rf"\[+\s*{KEY}[\s\].]|{KEY}[\s.\w-]*=")
# Whole numbers of more bits than a double can hold are not written out.
_LONGEST_WHOLE = 1100
_LONGEST_VALUE = 60


def read_scene(path: str | Path) -> Scene:
    """Read and check a scene file.

    Raises SceneError: the file can't be read, is not TOML, or holds something that a scene may not;
    all problems at once.
    """
    return parse_scene(load_toml(path), path)


def load_toml(path: str | Path) -> dict[str, Any]:
    """Read the content of a TOML file that a user wrote.

    Raises SceneError: the file can't be read, is larger than 4 MB, is not UTF-8 text, or is not
    TOML, whose whole numbers have 64 bits at most.
    """
    return parse_toml(read_bytes(path), path)


def read_bytes(path: str | Path) -> bytes:
    """Read a file that a user wrote.

    Raises SceneError: it can't be read, is no regular file, or larger than 4 MB.
    """
    try:
        return regular_bytes(Path(path), _MAXIMUM_BYTES)
    except ForeignError as error:
        raise SceneError(clean(str(path)), [str(error)]) from error


def parse_toml(content: bytes, path: str | Path) -> dict[str, Any]:
    """Return what the bytes of a TOML file say; `path` and errors as of `load_toml`."""
    if len(content) > _MAXIMUM_BYTES:
        raise SceneError(path, [f"larger than {_MAXIMUM_BYTES} bytes; such a file is small"])
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        said, before = f"is not UTF-8 text (byte {error.start})", content[: error.start]
        raise SceneError(path, [said], [_place(before.decode("utf-8"))]) from error
    if text.startswith(_BYTE_ORDER_MARK):
        raise SceneError(path, ["begins with a byte order mark; save it as UTF-8 without one"])
    long_at = long_key(text)
    if long_at is not None:
        raise SceneError(path, [LONG_KEY], [_place(text[:long_at])])
    try:
        data = tomllib.loads(text)
        long = [
            Problem(f"{_key(at)}: a whole number of {bits} bits; TOML has those of 64 at most", at)
            for at, bits in _long_numbers(data)
        ]
    except RecursionError as error:
        raise SceneError(path, ["is not valid TOML: nested too deeply"]) from error
    except ValueError as error:  # of tomllib, and of Python for numbers of thousands of digits
        said, place = _syntax(str(error), text)
        raise SceneError(path, [f"is not valid TOML: {said}"], [place]) from error
    if long:
        raise SceneError(path, long)
    return data


def _long_numbers(value: Any, path: KeyPath = ()) -> Iterator[tuple[KeyPath, int]]:
    """Paths and bits of whole numbers that are too long; a message could not even show some."""
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        yield path, value.bit_length()
    elif isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from _long_numbers(inner, (*path, key))


def _place(before: str) -> str:
    """Line and column of what follows a text."""
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def _syntax(said: str, text: str) -> tuple[str, str]:
    """What the parser says without its place, and that; with a hint where a number has a comma."""
    if said.endswith(_AT_END):
        return said.removesuffix(_AT_END) + " at the end", _place(text)
    found = _AT.search(said)
    if found is None:
        return said, ""
    said, lines = said[: found.start()], text.split("\n")
    line, at = lines[int(found[1]) - 1] if int(found[1]) <= len(lines) else "", int(found[2]) - 1
    if said in _UNCLOSED:
        return _unclosed(said, text, len("\n".join([*lines[: int(found[1]) - 1], line[:at]])))
    if said == _NO_KEY and line[:at].rstrip().endswith((",", "{")) and line[at : at + 1] in "}#\r":
        closed = line[at : at + 1] == "}"
        said += (
            f"; {'no comma stands before }' if closed else 'an inline table stands on one line'}"
        )
    is_comma = any(
        words in said and before.search(line[:at]) and behind.match(line[at:])
        for words, before, behind in _BEHIND_NUMBER
    )
    return said + (_COMMA if is_comma else ""), f"{found[1]}:{found[2]}"


def _unclosed(said: str, text: str, at: int) -> tuple[str, str]:
    """What is missing behind the last value before a place, and where that ends."""
    last = last_token(text, at)
    if last is None:
        return said, _place(text[:at])
    end, value = last
    closing = _UNCLOSED[said]
    between, rest = text[end:at], text[at:]
    if closing == "}" and rest[:1] in ("\n", "\r", "#"):
        what = "its line ends, and an inline table stands on one line: is the closing } missing"
    elif not rest or ("\n" in between and closing == "]" and _NEXT_LINE.match(rest)):
        what = f"is the closing {closing} missing"
    else:
        what = "is a comma missing"
    return f"{said}; {what} after {shown_value(value).strip(chr(39))}?", _place(text[:end])


def parse_scene(
    data: dict[str, Any], path: str | Path = "scene", *, folder: Path | None = None
) -> Scene:
    """Check the content of a scene file.

    `folder`: where files that the scene names are looked for; the folder of `path` if not given.
    Raises SceneError: all problems at once.
    """
    try:
        scene = Scene.model_validate(data, context={"folder": folder or Path(path).parent})
    except ValidationError as error:
        raise SceneError(path, explained(error)) from error
    scene, problems = with_files_read(scene)
    if problems:
        raise SceneError(path, problems)
    scene, problems = with_mesh_files_read(scene)
    if problems:
        raise SceneError(path, problems)
    scene, problems = with_laws_read(scene)
    if problems:
        raise SceneError(path, problems)
    problems = reference_problems(scene)
    if scene.sweep is not None:
        problems += [*sweep_problems(scene.sweep), *place_problems(data, scene.sweep)]
    if problems:
        raise SceneError(path, problems)
    return scene


def files_named(data: Mapping[str, Any], folder: Path) -> Iterator[Path]:
    """Yield the files that the content of a scene file names, whether or not they are there."""
    tables = (data.get(name) for name in ("imported", "mesh_bodies", "speed_laws"))
    entries = [e for t in tables if isinstance(t, dict) for e in t.values() if isinstance(e, dict)]
    analyses = data.get("analyses")
    asked = analyses if isinstance(analyses, list) else []
    measured = [a.get("measured") for a in asked if isinstance(a, dict)]
    entries += [m for m in measured if isinstance(m, dict)]
    for name in (e.get(key) for e in entries for key in ("file", "nodes", "functions", "modes")):
        if isinstance(name, str):
            yield folder / name


def scene_hash(scene: Scene) -> str:
    """SHA-256 of the scene's content, the same for files that say the same."""
    update = without_folders(scene)
    alike = scene.model_copy(update={**update, "analyses": analyses_without_folders(scene)})
    absent = {key for key, found in update.items() if not found}
    absent |= set() if scene.references else {"references"}
    text = alike.model_dump_json(exclude=absent)
    return hashlib.sha256(text.encode()).hexdigest()


def with_model(scene: Scene, *, level: str | None, accuracy: float | None) -> Scene:
    """The scene with another level or accuracy.

    Raises pydantic.ValidationError: a value that a scene file could not have either.
    """
    changes = {"level": level, "accuracy": accuracy}
    model = scene.model.model_dump() | {k: v for k, v in changes.items() if v is not None}
    return scene.model_copy(update={"model": type(scene.model).model_validate(model)})


# Errors where a number was wanted, and texts that begin with one.
_OF_NUMBERS, _NUMBER_FIRST = ("float_type", "int_type", "shape"), re.compile(r"\s*[+-]?\.?\d")
# Why no table of numbers is allowed.
_ISOTROPIC = {"materials": ": materials are isotropic and the same at all speeds"}


def explained(error: ValidationError, root: type[BaseModel] = Scene) -> list[str]:
    """Lines for what pydantic says of a file whose content is that of a record."""
    found = [e for e in error.errors(include_url=False) if not _is_of_its_items(e)]
    lines = [line for e in found[:_MAXIMUM_PROBLEMS] for line in _explained(e, root)]
    left = len(found) - _MAXIMUM_PROBLEMS
    return [*lines, f"and {left} more problems"] if left > 0 else lines


def _is_of_its_items(error: Any) -> bool:
    """Whether a list is called too short because its items, which are told, are wrong."""
    items = error.get("input")
    least = (error.get("ctx") or {}).get("min_length", 0)
    return error["type"] == "too_short" and isinstance(items, list | tuple) and len(items) >= least


def _explained(error: Any, root: type[BaseModel]) -> list[str]:
    """Lines for one of pydantic's errors; where a kind is missing, its key may be misspelt."""
    location, union = _in_file(error["loc"], root)
    path = tuple(part for part in location if part != "[key]")
    lines: list[str] = [Problem(_explain(error, root), path)]
    if error["type"] == "union_tag_not_found" and isinstance(error.get("input"), dict):
        known = {key for record in _kinds(union).values() for key in keys_of(record)}
        for key in [k for k in error["input"] if k not in known][:_MAXIMUM_PROBLEMS]:
            text = f"{_key((*location, key))}: unknown key; {meant(key, known)}"
            lines.append(Problem(text.rstrip("; "), (*path, key)))
    return lines


def _explain(error: Any, root: type[BaseModel]) -> str:
    """One line for one of pydantic's errors."""
    location, record = _in_file(error["loc"], root)
    where = _key(location)
    found = error.get("input")
    kind = error["type"]
    if kind == "extra_forbidden":
        _, holder = _in_file(error["loc"][:-1], root)
        names = list(keys_of(holder)) if _is_record(holder) else []
        hint = meant(str(location[-1]), names) or ("allowed are " + ", ".join(names))
        return f"{where}: unknown key" + (f"; {hint.strip()}" if names else "")
    if kind == "missing":
        return f"{where}: missing; this key is needed"
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        return f"{where}.kind: {_explain_kind(error, list(_kinds(record)))}"
    message = str(error["msg"]).removeprefix("Value error, ")
    for word, said in _TOML_WORDS.items():
        message = message.replace(word, said)
    if kind == "float_type" and isinstance(found, list | tuple | dict):
        # such as moduli by direction, which a reader of manuals may expect
        message = "one number is allowed here" + _ISOTROPIC.get(str(location[0]), "")
        found = list(found)
    shown = "" if isinstance(found, dict) else f", found {shown_value(found)}"
    if kind == "literal_error" and isinstance(found, str):
        words = re.findall(r"'([^']*)'", str((error.get("ctx") or {}).get("expected", "")))
        shown += f"; {meant(found, words)}".rstrip("; ")
    elif kind in _OF_NUMBERS and isinstance(found, str) and _NUMBER_FIRST.match(found):
        shown += "; a number stands without quotes, and its unit is in the key"
    return f"{where}: {message}{shown}"


def _explain_kind(error: Any, kinds: list[str]) -> str:
    allowed = "allowed are " + ", ".join(repr(k) for k in kinds)
    if error["type"] == "union_tag_not_found":
        return f"missing; {allowed}"
    tag = str(error["ctx"]["tag"])
    return f"no kind {shown_value(tag)}; {meant(tag, kinds)}{allowed}"


def _key(location: tuple[Any, ...]) -> str:
    out = ""
    for part in location:
        if isinstance(part, int):
            out += f"[{part}]"
        elif part != "[key]":
            text = shown_key(part)
            out += f".{text}" if out else text
    return out or "scene"


def shown_key(key: str) -> str:
    """Return a key for a message: as it is, or in quotes where TOML needs them, and short."""
    return key if _BARE_KEY.fullmatch(key) else shown_value(key)


def shown_value(value: Any) -> str:
    """Return a value of a TOML file for a message, short whatever it is."""
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, list):
        if len(value) > 4 or any(isinstance(v, dict | list) for v in value):
            return f"an array of {len(value)}"
        return f"[{', '.join(shown_value(v) for v in value)}]"
    if isinstance(value, int) and value.bit_length() > _LONGEST_WHOLE:
        return f"a whole number of {value.bit_length()} bits"
    text = repr(value[: _LONGEST_VALUE + 1] if isinstance(value, str) else value)
    return clean(text if len(text) <= _LONGEST_VALUE else text[: _LONGEST_VALUE - 3] + "...")


def _in_file(location: tuple[Any, ...], root: type[BaseModel]) -> tuple[tuple[Any, ...], Any]:
    """Keys of the file in a location of pydantic's, which has the kinds of records between them.

    The second value is the type of what lies there, None if that is not known.
    """
    current: Any = root
    keys = []
    for part in location:
        kinds = _kinds(current)
        if part in kinds:
            current = kinds[part]
            continue
        keys.append(part)
        if _is_record(current):
            field = keys_of(current).get(str(part))
            current = _bare(field.annotation) if field is not None else None
        else:
            current = _element(current)
    return tuple(keys), current


def _is_record(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _bare(annotation: Any) -> Any:
    """Type without its notes, and without None beside it."""
    while typing.get_origin(annotation) is typing.Annotated:
        annotation = typing.get_args(annotation)[0]
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        members = [a for a in typing.get_args(annotation) if a is not type(None)]
        if len(members) == 1:
            return _bare(members[0])
    return annotation


def _kinds(annotation: Any) -> Mapping[Any, Any]:
    """Records of a union by their kind; empty for other types."""
    if annotation is Analysis:
        return KINDS
    if typing.get_origin(annotation) not in (typing.Union, types.UnionType):
        return {}
    records = [a for a in typing.get_args(annotation) if _is_record(a)]
    return {
        kind: record
        for record in records
        if "kind" in record.model_fields
        for kind in typing.get_args(record.model_fields["kind"].annotation)
    }


def _element(annotation: Any) -> Any:
    """Type of the elements of a container; None for other types."""
    arguments = [a for a in typing.get_args(annotation) if a is not Ellipsis]
    if typing.get_origin(annotation) is dict:
        return _bare(arguments[1])
    if typing.get_origin(annotation) in (tuple, list) and arguments:
        return _bare(arguments[0])
    return None
