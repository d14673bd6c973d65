"""Kinds of numbers and names in a scene file, and the base of its records."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    ValidationError,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WithJsonSchema,
    WrapValidator,
)
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

# strict: whole numbers stand for floats, but texts and true or false for no number
# far beyond every rotor, and far from where products of a few numbers overflow
_LARGEST = 1e30


def _not_tiny(value: float) -> float:
    """Refuse what underflows in products of a few numbers."""
    if 0.0 < value < 1.0 / _LARGEST:
        raise ValueError(f"{value:g} is too small; allowed is {1.0 / _LARGEST:g} and more")
    return value


class _Written:
    """A kind of number with its schema written down; pydantic else derives it for every key anew.

    Scenes have some two hundred keys of these kinds.
    """

    def __init__(self, schema: Callable[[], CoreSchema]) -> None:
        self._schema = schema

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        return self._schema()


_number = partial(core_schema.float_schema, le=_LARGEST, allow_inf_nan=False, strict=True)


def _sized(**least: Any) -> CoreSchema:
    return core_schema.no_info_after_validator_function(_not_tiny, _number(**least))


Positive = Annotated[float, _Written(partial(_sized, gt=0))]
NotNegative = Annotated[float, _Written(partial(_sized, ge=0))]
Finite = Annotated[float, _Written(partial(_number, ge=-_LARGEST))]
Count = Annotated[int, Field(ge=1, strict=True)]
Place = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}\.[A-Za-z][A-Za-z0-9_-]{0,63}$")]
Name = Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_-]{0,63}$")]
Switch = Literal["auto", "on", "off"]
Motion = Literal["ux", "uy", "uz", "rx", "ry", "rz"]


def _switch(value: Any) -> Any:
    """TOML's true and false are accepted for on and off."""
    return {True: "on", False: "off"}.get(value, value) if isinstance(value, bool) else value


_Handler = ValidatorFunctionWrapHandler
_Keys = tuple[int | str, ...]


def validated_at(handler: Callable[[Any], Any], value: Any, place: Callable[[_Keys], _Keys]) -> Any:
    """Validate what a value of a file stands for; what is wrong with it is told once, in the file.

    `place`: keys in the file, by those in what stands for it.
    """
    try:
        return handler(value)
    except ValidationError as error:
        told: dict[_Keys, InitErrorDetails] = {}
        for one in error.errors(include_url=False):
            # as a kind of its own, since others than pydantic's can't be made anew by their name
            code: Any = one["type"]
            said: Any = {**one.get("ctx", {}), "said": one["msg"]}
            kind = PydanticCustomError(code, "{said}", said)
            keys = place(one["loc"])
            told.setdefault(keys, InitErrorDetails(type=kind, loc=keys, input=one["input"]))
        raise ValidationError.from_exception_data(error.title, [*told.values()]) from None


def _refuse_shape(value: Any, allowed: str) -> None:
    """Refuse what is no number and no list; TOML's dates and texts, true and tables."""
    raise PydanticCustomError("shape", "{allowed} is needed", {"allowed": allowed})


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _pair(value: Any, handler: _Handler) -> Any:
    """A number stands for the same value at both ends."""
    if _is_number(value):
        return validated_at(handler, (value, value), lambda keys: ())
    if not (isinstance(value, list | tuple) and len(value) == 2):
        _refuse_shape(value, "a number, or a pair of them at the two ends,")
    return handler(value)


def several(value: Any, handler: _Handler) -> Any:
    """A number stands for a list of one."""
    if _is_number(value):
        return validated_at(handler, (value,), lambda keys: ())
    if not isinstance(value, list | tuple):
        _refuse_shape(value, "a number or a list of numbers")
    return handler(value)


def _matrix(value: Any, handler: _Handler) -> Any:
    """A number k is k·I, a pair (kx, ky) is diagonal, a 2×2 list stands for itself."""
    return _of_matrix(value, handler, "a number k, a pair [kx, ky] or [[kxx, kxy], [kyx, kyy]]")


def _of_matrix(value: Any, handler: _Handler, allowed: str) -> Any:
    if _is_number(value):
        return validated_at(handler, ((value, 0.0), (0.0, value)), lambda keys: ())
    if not (isinstance(value, list | tuple) and len(value) == 2):
        _refuse_shape(value, allowed)
    rows = [isinstance(row, list | tuple) for row in value]
    if not any(rows):
        diagonal = ((value[0], 0.0), (0.0, value[1]))
        return validated_at(handler, diagonal, lambda keys: keys[:1])
    if not all(rows) or any(len(row) != 2 for row in value):
        _refuse_shape(value, allowed)
    return handler(value)


def _one_line(value: str) -> str:
    """Refuse what would steer a terminal, end a line, or show a text in another order."""
    for character in value:
        control = unicodedata.category(character) in ("Cc", "Cs", "Zl", "Zp")
        if control or unicodedata.bidirectional(character) in _TURNING:
            raise ValueError(f"the control character {character!r} is not allowed in a text")
    return value


def _lines(value: str) -> str:
    _one_line(value.replace("\n", "").replace("\t", ""))
    return value


def alike_in_files(names: Sequence[str]) -> tuple[str, str] | None:
    """Return two names that some file systems take for the same, None if there are none."""
    first: dict[str, str] = {}
    for name in names:
        other = first.setdefault(name.lower(), name)
        if other != name:
            return other, name
    return None


def _file_name(value: str) -> str:
    """Refuse names that some systems keep for devices."""
    if value.upper() in _DEVICES:
        raise ValueError(f"{value!r} can not be the name of a file on all systems; choose another")
    return value


def _tilt_matrix(value: Any, handler: _Handler) -> Any:
    """A matrix on ux and uy, or one of four by four with the tilts as well."""
    if isinstance(value, list | tuple) and len(value) == 4:
        if not all(isinstance(row, list | tuple) and len(row) == 4 for row in value):
            raise ValueError("four rows of four numbers each are needed, on ux, uy, rx and ry")
        return handler(value)
    two = "a number k, a pair [kx, ky], [[kxx, kxy], [kyx, kyy]], or four rows of four numbers,"
    return _of_matrix(value, handler, two)


def _beside_scene(value: str, info: ValidationInfo) -> str:
    """Take the name of a file from the folder of the scene that names it, where that is known."""
    folder = (info.context or {}).get("folder")
    return value if folder is None else str((Path(folder) / value).absolute())


# Entries of a list in a scene: far beyond every engine, and still read in seconds.
MOST = 2001
# Marks that turn the direction of writing.
_TURNING = ("LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI")
_DEVICES = ("CON", "PRN", "AUX", "NUL", *(f"{d}{k}" for d in ("COM", "LPT") for k in range(10)))
Title = Annotated[str, Field(max_length=1000), AfterValidator(_one_line)]
#: What a file of another program calls a part of it.
GroupName = Annotated[Title, Field(min_length=1, max_length=200)]
Note = Annotated[str, Field(max_length=4000), AfterValidator(_lines)]
FileName = Annotated[Name, AfterValidator(_file_name)]
#: A file that a scene reads: a name relative to the scene's folder, made absolute when it is read.
BesideScene = Annotated[
    str,
    Field(min_length=1, max_length=1000),
    AfterValidator(_one_line),
    AfterValidator(_beside_scene),
]
EndText = Annotated[str, Field(max_length=129)]
AutoSwitch = Annotated[
    Switch, BeforeValidator(_switch), WithJsonSchema({"enum": ["auto", "on", "off", True, False]})
]
_ANY = {"type": "number"}
_TWO = {"type": "array", "items": _ANY, "minItems": 2, "maxItems": 2}
Radii = Annotated[
    tuple[NotNegative, NotNegative],
    WrapValidator(_pair),
    WithJsonSchema({"anyOf": [{**_ANY, "minimum": 0}, _TWO]}),
]
PositiveEnds = Annotated[
    tuple[Positive, Positive],
    WrapValidator(_pair),
    WithJsonSchema({"anyOf": [{**_ANY, "exclusiveMinimum": 0}, _TWO]}),
]
_Stagger = Annotated[float, Field(ge=-180, le=180, allow_inf_nan=False, strict=True)]
StaggerEnds = Annotated[
    tuple[_Stagger, _Stagger],
    WrapValidator(_pair),
    WithJsonSchema({"anyOf": [{**_ANY, "minimum": -180, "maximum": 180}, _TWO]}),
]
Matrix = Annotated[
    tuple[tuple[Finite, Finite], tuple[Finite, Finite]],
    WrapValidator(_matrix),
    WithJsonSchema({"anyOf": [_ANY, _TWO, {**_TWO, "items": _TWO}]}),
]
_FOUR = {"type": "array", "items": _ANY, "minItems": 4, "maxItems": 4}
#: On (ux, uy), or on (ux, uy, rx, ry)
TiltMatrix = Annotated[
    tuple[tuple[Finite, ...], ...],
    WrapValidator(_tilt_matrix),
    WithJsonSchema({"anyOf": [_ANY, _TWO, {**_TWO, "items": _TWO}, {**_FOUR, "items": _FOUR}]}),
]
ZERO_MATRIX = ((0.0, 0.0), (0.0, 0.0))


class Record(BaseModel):
    """Base of all scene records: frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False, defer_build=True)

    def __eq__(self, other: object) -> bool:
        """Whether both say the same; where in a file it stood is no part of that."""
        return type(self) is type(other) and self.__dict__ == other.__dict__


def keys_of(record: type[BaseModel]) -> dict[str, FieldInfo]:
    """Return the fields of a record by their keys in files; one may be a word of Python."""
    return {field.alias or name: field for name, field in record.model_fields.items()}
