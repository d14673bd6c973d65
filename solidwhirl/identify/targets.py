"""What a problem wants of its scene: published numbers, or measurements with their uncertainty."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from solidwhirl.core.errors import repeated
from solidwhirl.core.fields import MOST, Count, Finite, Name, NotNegative, Place, Positive, Title
from solidwhirl.scene_reading.paths import choice

Share = Annotated[float, Field(gt=0, le=0.5, strict=True)]
_TOLERANCE = 1e-3


class ProblemRecord(BaseModel):
    """Base of all records of a problem file: frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class TargetSpec(ProblemRecord):
    """A quantity and the value that it should have, or that was measured."""

    name: Name
    quantity: Literal[
        "mass_kg",
        "center_of_gravity_m",
        "polar_inertia_kg_m2",
        "diametral_inertia_kg_m2",
        "frequency_hz",
        "mode_shape",
    ]
    value: Finite = 0.0
    tolerance: Share = _TOLERANCE
    uncertainty: Positive | None = None
    use: Literal["fit", "check"] = "fit"
    body: Name | None = None
    mode: Count | None = None
    speed_rpm: NotNegative = 0.0
    at: Annotated[tuple[Place, ...], Field(max_length=MOST)] = ()
    direction: Literal["x", "y"] = "x"
    shape: Annotated[tuple[Finite, ...], Field(max_length=MOST)] = ()
    source: Title = ""

    @property
    def spread(self) -> float:
        """Its tolerance, or standard deviation, as a part of its value or largest motion."""
        if self.uncertainty is None:
            return self.tolerance
        largest = max((abs(v) for v in self.shape or (self.value,)), default=0.0)
        return self.uncertainty / largest if largest else self.tolerance


def is_mass_target(target: TargetSpec) -> bool:
    """Whether a target has a closed form in the geometry alone."""
    return target.quantity not in ("frequency_hz", "mode_shape")


def is_measured(targets: Sequence[TargetSpec]) -> bool:
    """Whether targets are measurements: one of them tells its uncertainty."""
    return any(target.uncertainty is not None for target in targets)


def target_problems(
    targets: Sequence[TargetSpec], bodies: list[str], places: Sequence[str]
) -> Iterator[str]:
    """Yield what is wrong with targets, each line beginning with its key.

    `bodies`, `places`: bodies and interfaces of the scene.
    """
    yield from repeated("targets", [t.name for t in targets])
    measured = is_measured(targets)
    wanted: dict[tuple[Any, ...], int] = {}
    for k, t in enumerate(targets):
        where = f"targets[{k}]"
        first = wanted.setdefault((t.quantity, t.body, t.mode, t.speed_rpm, t.direction), k)
        if first != k:
            yield f"{where}: the same quantity as targets[{first}]; give it once"
        if measured and t.uncertainty is None:
            yield (
                f"{where}.uncertainty: missing; where one target is measured all need their "
                "standard deviation, in the unit of the value"
            )
        if t.uncertainty is not None and "tolerance" in t.model_fields_set:
            yield f"{where}.tolerance: a measured target has its uncertainty; leave one out"
        yield from (f"{where}.{text}" for text in _value_problems(t))
        yield from (f"{where}.{text}" for text in _quantity_problems(t, bodies, places))


def data_problems(
    targets: Sequence[TargetSpec], parameters: int, prior_is_set: bool
) -> Iterator[str]:
    """Yield why measurements can not decide on so many parameters."""
    if not is_measured(targets):
        return
    data = sum(max(len(t.shape) - 1, 1) for t in targets if t.use == "fit")
    if parameters > data:
        yield (
            f"parameters: {parameters}, but the targets that are fitted are {data} data (a shape "
            "of n places is n - 1); measurements decide on as many at most: fix parameters at "
            "known values, or add targets"
        )
    if prior_is_set:
        yield (
            "settings.prior: measured targets decide alone; a pull towards the starts would make "
            "intervals too narrow, so only 0 is allowed"
        )


def _value_problems(t: TargetSpec) -> Iterator[str]:
    if t.quantity == "mode_shape":
        if "value" in t.model_fields_set:
            yield "value: a mode_shape has shape, one number for each place"
        if len(t.shape) != len(t.at) or len(t.shape) < 2:
            yield (
                f"shape: {len(t.shape)} numbers at {len(t.at)} places; as many are needed, 2 at "
                "least"
            )
        elif len(set(t.at)) < len(t.at):
            yield "at: a place is there twice; each has one number in the shape"
        elif not any(t.shape):
            yield "shape: all numbers are 0"
        if t.uncertainty is None:
            yield "uncertainty: missing; a mode_shape needs the standard deviation of its numbers"
    else:
        if t.value == 0.0:
            yield "value: 0; deviations are relative, so the value may not be zero"
        elif t.value < 0.0 and t.quantity != "center_of_gravity_m":
            yield f"value: {t.value:g}; {t.quantity} is above zero"
        if t.shape or t.at:
            yield f"shape: {t.quantity} has no shape and no places"


def _quantity_problems(t: TargetSpec, bodies: list[str], places: Sequence[str]) -> Iterator[str]:
    if is_mass_target(t):
        if t.body not in bodies:
            found = "missing" if t.body is None else f"no body {t.body!r}"
            yield f"body: {found}; {choice(t.body or '', bodies)}"
        if t.mode is not None or t.speed_rpm:
            yield f"mode: {t.quantity} has neither mode nor speed_rpm"
        return
    if t.mode is None:
        yield f"mode: missing; {t.quantity} needs the number of the mode, from 1"
    if t.body is not None:
        yield f"body: {t.quantity} is a quantity of the whole scene; leave body out"
    if t.quantity == "mode_shape" and t.speed_rpm:
        yield "speed_rpm: shapes are those at rest"
    for j, place in enumerate(t.at):
        if place not in places:
            yield f"at[{j}]: no interface {place!r}; {choice(place, list(places))}"
