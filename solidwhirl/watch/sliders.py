"""Sliders of a scene: numbers of its bearings and operating speeds, as the file has them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from solidwhirl.core.errors import KeyPath, SceneError
from solidwhirl.core.key_units import name_of, unit_of
from solidwhirl.scene.joints import BearingSpec
from solidwhirl.scene.records import Scene
from solidwhirl.scene_reading.paths import is_number, with_entries

# Keys of a bearing that hold coefficients.
_COEFFICIENTS = tuple(k for k in BearingSpec.model_fields if "stiffness" in k or "damping" in k)
# What a table over the speed gives in their place.
_IN_TABLES = ("stiffness_n_per_m", "damping_n_s_per_m")
# A logarithmic slider reaches this factor each way, a linear one this many times its number.
_FACTOR, _TIMES = 100.0, 2.0
# Reach of a number that is zero, where no other of its key says how large they are.
_USUAL = {"stiffness": 1e7, "damping": 1e4}
_PLANES = "xy"


@dataclass(frozen=True, kw_only=True)
class Slider:
    """A number of the scene file that may be moved."""

    #: Places of the file that have it; several only where an operating speed is no range
    paths: tuple[KeyPath, ...]
    #: What it belongs to, and what it is
    group: str
    label: str
    unit: str
    value: float
    low: float
    high: float
    #: Else linear
    is_log: bool

    @property
    def name(self) -> str:
        """Name by which the page asks for it."""
        return ".".join(map(str, self.paths[0]))

    def document(self) -> dict[str, Any]:
        """Return what the page knows of it."""
        keys = ("name", "group", "label", "unit", "value", "low", "high", "is_log")
        return {key: getattr(self, key) for key in keys}


@dataclass(frozen=True, kw_only=True)
class Controls:
    """What may be moved in a scene, and what stays as it is: (group, text)."""

    sliders: tuple[Slider, ...]
    fixed: tuple[tuple[str, str], ...]

    def moved(self, positions: Mapping[str, float]) -> dict[KeyPath, float]:
        """Return the numbers of the file at positions of sliders by name, those that differ."""
        return {
            path: positions[s.name]
            for s in self.sliders
            if positions.get(s.name, s.value) != s.value
            for path in s.paths
        }


def controls_of(data: Mapping[str, Any]) -> Controls:
    """Return the sliders of the content of a scene file, bearings first."""
    sliders = [*_of_bearings(data), *_of_speeds(data.get("operating", []))]
    return Controls(sliders=tuple(sliders), fixed=tuple(_fixed(data)))


def scene_at(scene: Scene, data: Mapping[str, Any], numbers: Mapping[KeyPath, float]) -> Scene:
    """Return a scene with other numbers at bearings and operating speeds; reads no files.

    `data`: content of its file. Raises SceneError: a number that can not be.
    """
    from pydantic import ValidationError

    from solidwhirl.scene_reading.reader import explained

    try:
        found = Scene.model_validate(with_entries(data, dict(numbers)))
    except ValidationError as error:
        raise SceneError(scene.name, explained(error)) from error
    return scene.model_copy(update={"bearings": found.bearings, "operating": found.operating})


def _of_bearings(data: Mapping[str, Any]) -> Iterator[Slider]:
    bearings = data.get("bearings", [])
    for k, bearing in enumerate(bearings):
        for key in _COEFFICIENTS:
            if key not in bearing or (key in _IN_TABLES and _has_table(data, bearing)):
                continue
            zero = _usual_size(bearings, key)
            for path, value, places in _numbers(bearing[key]):
                diagonal = len(set(places)) < 2
                low, high = _range(value, zero, may_be_negative=not diagonal)
                yield Slider(
                    paths=(("bearings", k, key, *path),),
                    group=f"Bearing {bearing['name']}",
                    label=" ".join([name_of(key).replace("_", " "), places]).strip(),
                    unit=unit_of(key),
                    value=float(value),
                    low=low,
                    high=high,
                    is_log=value > 0.0,
                )


def _numbers(value: Any) -> Iterator[tuple[KeyPath, float, str]]:
    """Numbers of a coefficient: where they are in it, the number, and its planes, such as "xy"."""
    if is_number(value):
        yield (), value, ""
        return
    for i, row in enumerate(value):
        if is_number(row):
            yield (i,), row, 2 * _PLANES[i]
        else:
            yield from (((i, j), v, _PLANES[i] + _PLANES[j]) for j, v in enumerate(row))


def _usual_size(bearings: Sequence[Mapping[str, Any]], key: str) -> float:
    """How large numbers of a key are."""
    found = [abs(v) for b in bearings if key in b for _, v, _ in _numbers(b[key])]
    usual = next(size for word, size in _USUAL.items() if word in key)
    return max(found, default=0.0) or usual


def _range(value: float, zero: float, *, may_be_negative: bool) -> tuple[float, float]:
    if value > 0.0:
        return value / _FACTOR, value * _FACTOR
    if value < 0.0:
        return _TIMES * value, -_TIMES * value
    return (-zero if may_be_negative else 0.0), zero


def _of_speeds(operating: Sequence[Mapping[str, Any]]) -> Iterator[Slider]:
    for k, entry in enumerate(operating):
        ends = {"from_rpm": "from", "to_rpm": "to"}
        if entry["from_rpm"] == entry["to_rpm"]:
            ends = {"from_rpm": "speed"}
        for key, label in ends.items():
            value = float(entry[key])
            paths = [key] if len(ends) > 1 else ["from_rpm", "to_rpm"]
            yield Slider(
                paths=tuple(("operating", k, key) for key in paths),
                group=f"Operating speed of {entry['shaft']}",
                label=label,
                unit="rpm",
                value=value,
                low=value / _FACTOR,
                high=_TIMES * value,
                is_log=False,
            )


def _has_table(data: Mapping[str, Any], bearing: Mapping[str, Any]) -> bool:
    law = data.get("speed_laws", {}).get(bearing.get("speed_law"), {})
    return bool(law.get("kind", "preset") not in ("polynomial", "preset"))


def _fixed(data: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for bearing in data.get("bearings", []):
        group, law = f"Bearing {bearing['name']}", bearing.get("speed_law")
        if _has_table(data, bearing):
            yield group, f"stiffness and damping by the table {law} over the speed"
        elif law is not None:
            yield group, f"times the law {law} over the speed"
        if bearing.get("rigid"):
            yield group, f"rigid: {', '.join(bearing['rigid'])}"
