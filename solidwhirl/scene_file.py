"""Reading a scene file, with messages that name file, key, finding and what is allowed."""

from __future__ import annotations

import difflib
import hashlib
import tomllib
import types
import typing
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from solidwhirl.errors import SceneError
from solidwhirl.references import reference_problems
from solidwhirl.scene import Scene

_MAXIMUM_BYTES = 4_000_000
_TOML_WORDS = {"tuple": "array", "Tuple": "Array", "dictionary": "table", "Dictionary": "Table"}


def read_scene(path: str | Path) -> Scene:
    """Read and check a scene file.

    Parameters
    ----------
    path
        A TOML file.

    Returns
    -------
    Scene

    Raises
    ------
    SceneError
        The file can't be read, is not TOML, or holds something that a scene may not; all problems
        at once.
    """
    path = Path(path)
    try:
        if path.stat().st_size > _MAXIMUM_BYTES:
            raise SceneError(path, [f"larger than {_MAXIMUM_BYTES} bytes; a scene file is small"])
        text = path.read_bytes().decode("utf-8")
    except OSError as error:
        raise SceneError(path, [f"can not be read: {error.strerror or error}"]) from error
    except UnicodeDecodeError as error:
        raise SceneError(path, [f"is not UTF-8 text (byte {error.start})"]) from error
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise SceneError(path, [f"is not valid TOML: {error}"]) from error
    return parse_scene(data, path)


def parse_scene(data: dict[str, Any], path: str | Path = "scene") -> Scene:
    """Check the content of a scene file.

    Raises
    ------
    SceneError
        All problems at once.
    """
    try:
        scene = Scene.model_validate(data)
    except ValidationError as error:
        raise SceneError(path, [_explain(e) for e in error.errors(include_url=False)]) from error
    problems = reference_problems(scene)
    if problems:
        raise SceneError(path, problems)
    return scene


def scene_hash(scene: Scene) -> str:
    """SHA-256 of the scene's content, the same for files that say the same."""
    return hashlib.sha256(scene.model_dump_json().encode()).hexdigest()


def with_model(scene: Scene, *, level: str | None, accuracy: float | None) -> Scene:
    """The scene with another level or accuracy.

    Raises
    ------
    pydantic.ValidationError
        A value that a scene file could not have either.
    """
    changes = {"level": level, "accuracy": accuracy}
    model = scene.model.model_dump() | {k: v for k, v in changes.items() if v is not None}
    return scene.model_copy(update={"model": type(scene.model).model_validate(model)})


def _explain(error: Any) -> str:
    """One line for one of pydantic's errors."""
    where = _key(error["loc"])
    found = error.get("input")
    kind = error["type"]
    if kind == "extra_forbidden":
        return f"{where}: unknown key{_suggestion(error['loc'])}"
    if kind == "missing":
        return f"{where}: missing; this key is needed"
    message = str(error["msg"]).removeprefix("Value error, ")
    for word, said in _TOML_WORDS.items():
        message = message.replace(word, said)
    shown = "" if isinstance(found, dict) else f", found {_short(found)}"
    return f"{where}: {message}{shown}"


def _key(location: tuple[Any, ...]) -> str:
    out = ""
    for part in location:
        if isinstance(part, int):
            out += f"[{part}]"
        elif part != "[key]":
            text = part if part.isprintable() else _short(part)
            out += f".{text}" if out else text
    return out or "scene"


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _suggestion(location: tuple[Any, ...]) -> str:
    """Allowed keys at a place, the nearest first."""
    model = _model_at(Scene, location[:-1])
    if model is None:
        return ""
    names = list(model.model_fields)
    near = difflib.get_close_matches(str(location[-1]), names, n=1, cutoff=0.6)
    if near:
        return f"; did you mean {near[0]!r}?"
    return "; allowed are " + ", ".join(names)


def _model_at(annotation: Any, location: tuple[Any, ...]) -> type[BaseModel] | None:
    """Record type that a location in the data leads to."""
    current: Any = annotation
    for part in location:
        if isinstance(current, type) and issubclass(current, BaseModel):
            field = current.model_fields.get(str(part))
            if field is None:
                return None
            current = field.annotation
        else:
            current = _element(current)
    while not (isinstance(current, type) and issubclass(current, BaseModel)):
        inner = _element(current)
        if inner is None:
            return None
        current = inner
    return current


def _element(annotation: Any) -> Any:
    """Type of the elements of a container, or of the non-None part of a union."""
    origin = typing.get_origin(annotation)
    arguments = [a for a in typing.get_args(annotation) if a not in (type(None), Ellipsis)]
    if origin in (dict, tuple, list, typing.Annotated, typing.Union, types.UnionType):
        return arguments[1] if origin is dict else (arguments[0] if arguments else None)
    return None
