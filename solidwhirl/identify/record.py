"""What an identification found and how well the data determine it, as data and as text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from solidwhirl.core.errors import markdown_row, markdown_text
from solidwhirl.core.versions import package_versions
from solidwhirl.identify.problem import Problem
from solidwhirl.identify.search import Descent
from solidwhirl.identify.statistics import (
    CONFIDENCE,
    UNLIKELY,
    Estimate,
    agrees,
    estimate,
    not_told_apart,
    scores,
)
from solidwhirl.rotordyn.core.arrays import FloatArray

SCHEMA = "solidwhirl-identification-1"
# Share of a range within which a value counts as at its bound.
_AT_BOUND = 1e-3
# Variance of a value of which nothing but its bounds is known, in shares of the range.
_UNIFORM = 1.0 / 12.0
# Of a target, told even where they are the default.
_ALWAYS = ("quantity", "body", "mode", "speed_rpm", "source", "use")
# Shares of a direction that are worth naming.
_NAMED = 0.25


@dataclass(frozen=True, kw_only=True, eq=False)
class Identification:
    """The result of an identification."""

    problem: Problem
    values: Mapping[str, float]  # identified values by parameter
    point: FloatArray  # the same in the unit cube of the bounds, (n,)
    reached: FloatArray  # quantities of the targets at the problem's accuracy, (t,)
    slopes: FloatArray  # d(deviation in units of the tolerance)/d(point), (t, n)
    starts: tuple[Descent, ...]
    ended: str  # why the last search ended
    evaluations: int  # evaluations of the whole model
    infeasible: tuple[str, ...]  # messages of the points that had no model
    seconds: float  # wall time of this run, without what an earlier, interrupted one did

    @property
    def deviations(self) -> FloatArray:
        """Relative deviations of the targets' numbers, (rows,)."""
        return self.problem.rows.parts(self.reached)

    @property
    def met(self) -> bool:
        """Whether every target that is fitted is reached within its tolerance.

        Of measurements, whether their deviations are as small as their uncertainties allow.
        """
        rows = self.problem.rows
        probability = self.estimate.probability
        if self.problem.is_measured and probability is not None:
            return probability >= UNLIKELY
        # as many measurements as parameters are met, but for a bound in the way
        within = np.abs(self.deviations) <= rows.tolerance
        return bool(within[rows.is_fitted].all())

    @property
    def estimate(self) -> Estimate:
        """What the fitted targets say of the parameters."""
        rows = self.problem.rows
        deviations = rows.deviations(self.reached)[rows.is_fitted]
        # the scale of each shape uses up one of its data
        shapes = sum(bool(t.shape) for t in self.problem.spec.targets if t.use == "fit")
        return estimate(self.slopes[rows.is_fitted], deviations, shapes)


def sensitivities_per_range(found: Identification) -> FloatArray:
    """Return d ln(target)/d(parameter/(upper - lower)) at the result, (rows, n).

    Of shapes, the change as a part of the largest motion.
    """
    rows = found.problem.rows
    share = np.where(rows.is_single, 1.0 + found.deviations, 1.0)
    return np.asarray(found.slopes * (rows.tolerance / share)[:, None])


def relative_sensitivities(found: Identification) -> FloatArray:
    """Return d ln(target)/d ln(parameter) at the result, (rows, n)."""
    parameters = found.problem.spec.parameters
    span = np.array([p.upper - p.lower for p in parameters])
    value = np.array([found.values[p.name] for p in parameters])
    return np.asarray(sensitivities_per_range(found) * value / span)


def uncertainties(found: Identification) -> FloatArray:
    """Return the standard deviation that the data leave each parameter, (n,), its own unit.

    Each target is taken as known to its tolerance, each parameter beforehand as evenly spread
    over its bounds, and the model as linear: 0.29 of the range says that the data tell nothing.
    Of measurements it is half the interval of `CONFIDENCE` that they alone give.
    """
    spec = found.problem.spec
    span = np.array([p.upper - p.lower for p in spec.parameters])
    if found.problem.is_measured:
        return np.asarray(found.estimate.half_width * span)
    slopes = found.slopes[found.problem.rows.is_fitted]
    information = slopes.T @ slopes + np.eye(len(span)) / _UNIFORM
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))) * span)


def document(found: Identification) -> dict[str, Any]:
    """Everything about an identification as plain data."""
    problem = found.problem
    _, singular, right = np.linalg.svd(found.slopes[problem.rows.is_fitted])
    names = [p.name for p in problem.spec.parameters]
    padded = np.concatenate([singular, np.zeros(len(names) - len(singular))])[: len(names)]
    return {
        "schema": SCHEMA,
        "problem": {
            "name": problem.spec.name,
            "title": problem.spec.title,
            "notes": list(problem.spec.notes),
            "scene": problem.spec.scene,
            "sha256": problem.fingerprint,
            "settings": problem.spec.settings.model_dump(),
        },
        "met": found.met,
        "targets": _targets(found),
        "parameters": _parameters(found),
        "sensitivities": {
            "meaning": (
                "values: d ln(target) / d ln(parameter), rows are targets, columns parameters; "
                "per_range: d ln(target) / d(parameter / range), for parameters near zero"
            ),
            "targets": list(problem.rows.name),
            "parameters": names,
            "values": relative_sensitivities(found).tolist(),
            "per_range": sensitivities_per_range(found).tolist(),
        },
        "identifiability": {
            "meaning": (
                "singular values of d(target / tolerance) / d(parameter / range); a step of "
                "1 / value along a direction changes the targets by one tolerance"
            ),
            "undetermined_directions": int((padded < 1.0).sum()),
            "directions": [
                {"singular_value": float(s), "shares": dict(zip(names, v.tolist(), strict=True))}
                for s, v in zip(padded, right, strict=True)
            ],
        },
        "statistics": _statistics(found) if problem.is_measured else None,
        "search": _search(found),
        "packages": package_versions(),
    }


def _targets(found: Identification) -> list[dict[str, Any]]:
    rows, targets = found.problem.rows, found.problem.spec.targets
    return [
        {
            **targets[k].model_dump(exclude={"tolerance"}, exclude_defaults=True),
            **{key: getattr(targets[k], key) for key in _ALWAYS},
            "name": rows.name[row],
            "value": float(rows.wanted[row]),
            "reached": float(found.reached[row]),
            "deviation_percent": float(100.0 * found.deviations[row]),
            "tolerance_percent": float(100.0 * rows.tolerance[row]),
            "met": bool(abs(found.deviations[row]) <= rows.tolerance[row]),
        }
        for row, k in enumerate(rows.target)
    ]


def _statistics(found: Identification) -> dict[str, Any]:
    """What measurements say: spread, what they can not tell apart, and those kept aside."""
    names, own = [p.name for p in found.problem.spec.parameters], found.estimate
    span = np.array([p.upper - p.lower for p in found.problem.spec.parameters])
    value = np.array([found.values[name] for name in names])
    half = own.half_width * span
    rows = found.problem.rows
    aside = np.flatnonzero(~rows.is_fitted)
    score = scores(found.slopes[aside], rows.deviations(found.reached)[aside], own)
    return {
        "confidence": CONFIDENCE,
        "intervals": {
            name: [float(v - h), float(v + h)] if np.isfinite(h) else None
            for name, v, h in zip(names, value, half, strict=True)
        },
        "correlation": own.correlation.tolist(),
        "not_told_apart": [[names[i], names[k]] for i, k in not_told_apart(own)],
        "chi_squared": own.chi_squared,
        "degrees_of_freedom": own.freedom,
        "probability": own.probability,
        "kept_aside": [
            {
                "name": rows.name[row],
                "measured": float(rows.wanted[row]),
                "predicted": float(found.reached[row]),
                "standard_deviations": float(z),
                "agrees": bool(ok),
            }
            for row, z, ok in zip(aside, score, agrees(score), strict=True)
        ],
    }


def _parameters(found: Identification) -> list[dict[str, Any]]:
    spread = uncertainties(found)
    return [
        {
            "name": p.name,
            "value": found.values[p.name],
            "plus_minus": float(spread[k]) if np.isfinite(spread[k]) else None,
            "lower": p.lower,
            "upper": p.upper,
            "start": p.start,
            "at_bound": _bound(float(found.point[k])),
            "places": list(p.places),
            "why": p.why,
        }
        for k, p in enumerate(found.problem.spec.parameters)
    ]


def _bound(share: float) -> str | None:
    if share < _AT_BOUND:
        return "lower"
    return "upper" if share > 1.0 - _AT_BOUND else None


def _search(found: Identification) -> dict[str, Any]:
    return {
        "starts": [
            {
                "cost": float(d.cost) if np.isfinite(d.cost) else None,
                "largest_deviation_in_tolerances": (
                    float(d.largest) if np.isfinite(d.largest) else None
                ),
                "ended": d.ended,
                "distance_to_result": float(np.abs(d.point - found.point).max()),
            }
            for d in found.starts
        ],
        "ended": found.ended,
        "evaluations": found.evaluations,
        "infeasible": dict(Counter(found.infeasible)),
        "seconds": found.seconds,
    }


def text(found: Identification) -> str:
    """The record as Markdown."""
    from jinja2 import Environment, PackageLoader

    templates = Environment(loader=PackageLoader(__package__, ""), trim_blocks=True)
    templates.filters |= {"text": markdown_text, "row": markdown_row, "signed": "{:+.3f}".format}
    said: str = templates.get_template("report.md").render(document(found), named=_named)
    return said


def _named(shares: Mapping[str, float]) -> str:
    """The parameters that a direction is made of, the largest first."""
    large = sorted(shares.items(), key=lambda item: -abs(item[1]))
    return ", ".join(f"{v:+.2f} {n}" for n, v in large if abs(v) >= _NAMED)


def value_lines(found: Identification) -> Iterator[str]:
    """Yield a line per parameter: its value, what the targets leave open, and its bounds.

    Of measurements, what they can not tell apart follows, and what was kept aside.
    """
    for p in _parameters(found):
        bound = f", at its {p['at_bound']} bound" if p["at_bound"] else ""
        yield (
            f"{p['name']} = {p['value']:.6g} ± {_spread(p['plus_minus'])} "
            f"({p['lower']:g} to {p['upper']:g}{bound})"
        )

    if found.problem.is_measured:
        yield from _statistics_lines(_statistics(found))


def _spread(value: float | None) -> str:
    return "unknown" if value is None else f"{value:.2g}"


def _statistics_lines(found: Mapping[str, Any]) -> Iterator[str]:
    yield f"±: interval of {100.0 * found['confidence']:g} %"
    for first, second in found["not_told_apart"]:
        yield f"the data can not tell {first} and {second} apart"
    if found["probability"] is not None and found["probability"] < UNLIKELY:
        yield (
            f"deviations are larger than the uncertainties allow (probability "
            f"{found['probability']:.2g}): do not trust the intervals"
        )
    for one in found["kept_aside"]:
        said = "agrees" if one["agrees"] else "does not agree"
        yield (
            f"kept aside: {one['name']} measured {one['measured']:.6g}, predicted "
            f"{one['predicted']:.6g}, {said} ({one['standard_deviations']:+.1f} standard "
            "deviations)"
        )


def missed_lines(found: Identification) -> Iterator[str]:
    """Yield a line per target that is not reached within its tolerance."""
    for t in _targets(found):
        if not t["met"] and t["use"] == "fit":
            yield (
                f"{t['name']}: {t['reached']:.6g} instead of {t['value']:g}, "
                f"{t['deviation_percent']:+.2f} % where {t['tolerance_percent']:g} % is allowed"
            )
