"""Records of the scene file: `[sweep]`, which makes many cases of one scene."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from solidwhirl.core.errors import choice, repeated
from solidwhirl.core.fields import MOST, Count, Finite, Name, Record

# Cases of one sweep: far beyond what a cluster computes in a week, and still named in seconds.
MOST_CASES = 20_000
# Far beyond every rotor, as for all numbers of a scene.
_LARGEST = 1e30
_LONGEST_TEXT = 300
# Of a lognormal distribution: nine in ten values of a wider one are below a 50th of its mean.
_WIDEST = 100.0
Method = Literal["grid", "list", "latin_hypercube", "sobol"]
SAMPLED = ("latin_hypercube", "sobol")
PlaceText = Annotated[str, Field(min_length=1, max_length=_LONGEST_TEXT)]


def _single(value: Any) -> Any:
    """Let numbers and short texts through, which a key of a scene can have."""
    if isinstance(value, bool):
        raise ValueError('true and false are no values of a sweep; write "on" or "off"')
    if isinstance(value, str):
        if not value or len(value) > _LONGEST_TEXT or not value.isprintable():
            raise ValueError(f"a text of 1 to {_LONGEST_TEXT} printable characters is needed")
        return value
    if not isinstance(value, int | float):
        raise ValueError("a number or a text is needed")
    if not abs(value) <= _LARGEST:  # nan as well
        raise ValueError(f"a number from {-_LARGEST:g} to {_LARGEST:g} is needed")
    return value


Single = Annotated[Any, AfterValidator(_single)]


class SweepParameterSpec(Record):
    """A number or a text that differs from case to case; it may stand in several places."""

    name: Name
    places: Annotated[tuple[PlaceText, ...], Field(max_length=MOST)]
    applies: Literal["value", "factor"] = "value"
    values: Annotated[tuple[Single, ...], Field(max_length=MOST)] | None = None
    count: Annotated[Count, Field(ge=2, le=MOST)] | None = None
    spacing: Literal["linear", "logarithmic"] | None = None
    distribution: Literal["uniform", "log_uniform", "normal", "lognormal"] | None = None
    lower: Finite | None = None
    upper: Finite | None = None
    mean: Finite | None = None
    standard_deviation: Finite | None = None


class SweepSpec(Record):
    """Which cases are made of a scene."""

    method: Method
    samples: Annotated[Count, Field(le=MOST_CASES)] | None = None
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] | None = None
    parameters: Annotated[tuple[SweepParameterSpec, ...], Field(max_length=50)]


def sweep_problems(sweep: SweepSpec) -> Iterator[str]:
    """What contradicts itself in a sweep, whatever its scene is: one line each, key first."""
    if not sweep.parameters:
        yield "sweep.parameters: empty; what is swept is missing"
    yield from repeated("sweep.parameters", [p.name for p in sweep.parameters])
    yield from _sample_problems(sweep)
    for k, parameter in enumerate(sweep.parameters):
        for text in _parameter_problems(parameter, sweep.method):
            yield f"sweep.parameters[{k}].{text}"
    if sweep.method == "list":
        yield from _length_problems(sweep)
    if sweep.method == "grid":
        cases = math.prod(grid_length(p) for p in sweep.parameters)
        if cases > MOST_CASES:
            yield f"sweep.parameters: the grid has {cases} cases; at most {MOST_CASES} are allowed"


def grid_length(parameter: SweepParameterSpec) -> int:
    """Return how many values a parameter of a grid has."""
    return len(parameter.values) if parameter.values is not None else parameter.count or 1


def case_count(sweep: SweepSpec) -> int:
    """Return how many cases a sweep has that contradicts itself nowhere."""
    if sweep.samples is not None:
        return sweep.samples
    lengths = [grid_length(p) for p in sweep.parameters]
    return math.prod(lengths) if sweep.method == "grid" else lengths[0]


def nominal_text(scene: str, sweep: SweepSpec) -> str:
    """Say that a command which computes one case takes the values in the scene file."""
    return (
        "nominal case: values as in the scene file; "
        f"`solidwhirl batch {scene}` computes the {case_count(sweep)} cases of [sweep]"
    )


def _sample_problems(sweep: SweepSpec) -> Iterator[str]:
    """`samples` and `seed` belong to sampled sweeps alone."""
    if sweep.method not in SAMPLED:
        for key in ("samples", "seed"):
            if getattr(sweep, key) is not None:
                yield f"sweep.{key}: method {sweep.method!r} draws no samples; leave it out"
        return
    if sweep.samples is None:
        yield f"sweep.samples: missing; method {sweep.method!r} needs the number of cases"
    elif sweep.method == "sobol" and sweep.samples & (sweep.samples - 1):
        below = 1 << (sweep.samples.bit_length() - 1)
        yield (
            f"sweep.samples: {sweep.samples} is no power of 2, and only these keep Sobol's points "
            f"balanced; take {below} or {2 * below}"
        )


def _parameter_problems(parameter: SweepParameterSpec, method: Method) -> Iterator[str]:
    empty = [key for key in ("places", "values") if getattr(parameter, key) == ()]
    if empty:
        yield f"{empty[0]}: empty; one at least is needed"
    elif parameter.values is not None:
        yield from _superfluous(parameter, {"values"}, "stands beside values")
        yield from _text_problems(parameter)
    elif method in SAMPLED:
        yield from _sampled_problems(parameter)
    elif method == "list":
        yield from _missing(parameter, ("values",), "method 'list'")
    else:
        yield from _grid_problems(parameter)


def _superfluous(parameter: SweepParameterSpec, allowed: set[str], why: str) -> Iterator[str]:
    common = {"name", "places", "applies"}
    for key in sorted(parameter.model_fields_set - common - allowed):
        yield f"{key}: {why}; {choice(key, sorted(allowed))}"


def _missing(parameter: SweepParameterSpec, keys: tuple[str, ...], for_what: str) -> list[str]:
    """One line for all keys that are missing."""
    missing = [key for key in keys if getattr(parameter, key) is None]
    return [f"{' and '.join(missing)}: missing; {for_what} needs it"] if missing else []


def _text_problems(parameter: SweepParameterSpec) -> Iterator[str]:
    texts = [v for v in parameter.values or () if isinstance(v, str)]
    if texts and len(texts) != len(parameter.values or ()):
        yield f"values: {texts[0]!r} stands among numbers; give texts alone or numbers alone"
    elif texts and parameter.applies == "factor":
        yield f"values: {texts[0]!r} is no factor; give numbers"


def _grid_problems(parameter: SweepParameterSpec) -> Iterator[str]:
    """Of a grid without values."""
    keys = ("lower", "upper", "count")
    given = [key for key in keys if getattr(parameter, key) is not None]
    yield from _superfluous(parameter, {*keys, "spacing", "values"}, "is not for method 'grid'")
    if not given:
        yield "values: missing; a grid needs values, or lower, upper and count"
        return
    missing = _missing(parameter, keys, "a grid without values")
    yield from missing
    if not missing:
        yield from _range_problems(parameter, positive=parameter.spacing == "logarithmic")


def _sampled_problems(parameter: SweepParameterSpec) -> Iterator[str]:
    """Of Latin hypercubes and Sobol's points."""
    bounded = parameter.distribution in ("uniform", "log_uniform")
    moments = ("mean", "standard_deviation")
    if parameter.distribution is None:
        yield "distribution: missing; a sampled sweep needs it, or values that are equally likely"
        return
    what = f"distribution {parameter.distribution!r}"
    allowed = {"distribution", "lower", "upper", *(() if bounded else moments)}
    yield from _superfluous(parameter, allowed, f"is not for {what}")
    missing = _missing(parameter, ("lower", "upper") if bounded else moments, what)
    yield from missing
    if missing:
        return
    if bounded:
        yield from _range_problems(parameter, positive=parameter.distribution == "log_uniform")
    else:
        yield from _moment_problems(parameter)


def _range_problems(parameter: SweepParameterSpec, *, positive: bool) -> Iterator[str]:
    lower, upper = parameter.lower, parameter.upper
    if lower is None or upper is None:
        return
    if not lower < upper:
        yield f"upper: {upper:g} is not above lower = {lower:g}"
    elif positive and lower <= 0.0:
        yield f"lower: {lower:g} has no logarithm; a number above 0 is needed"


def _moment_problems(parameter: SweepParameterSpec) -> Iterator[str]:
    """Normal and lognormal, which bounds may cut off."""
    mean, deviation = parameter.mean or 0.0, parameter.standard_deviation or 0.0
    lower, upper = parameter.lower, parameter.upper
    logarithmic = parameter.distribution == "lognormal"
    if deviation <= 0.0:
        yield f"standard_deviation: {deviation:g}; a number above 0 is needed"
    elif logarithmic and mean <= 0.0:
        yield f"mean: {mean:g}; a lognormal distribution has a mean above 0"
    elif logarithmic and deviation / mean > _WIDEST:
        yield f"standard_deviation: {deviation:g} is more than {_WIDEST:g} times the mean"
    elif lower is not None and upper is not None and not lower < upper:
        yield f"upper: {upper:g} is not above lower = {lower:g}"
    else:
        yield from _tail_problems(mean, lower, upper)


def _tail_problems(mean: float, lower: float | None, upper: float | None) -> Iterator[str]:
    for key, bound, beyond in (("lower", lower, 1.0), ("upper", upper, -1.0)):
        if bound is not None and beyond * (bound - mean) >= 0.0:
            yield f"{key}: {bound:g} cuts off the mean, {mean:g}; that is no tail"


def _length_problems(sweep: SweepSpec) -> Iterator[str]:
    lengths = [len(p.values or ()) for p in sweep.parameters]
    for k, length in enumerate(lengths):
        if length and lengths[0] and length != lengths[0]:
            yield (
                f"sweep.parameters[{k}].values: {length} values, but sweep.parameters[0] has "
                f"{lengths[0]}; a list has one of each for every case"
            )
