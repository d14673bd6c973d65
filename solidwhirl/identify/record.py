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
from solidwhirl.rotordyn.core.arrays import FloatArray

SCHEMA = "solidwhirl-identification-1"
# Share of a range within which a value counts as at its bound.
_AT_BOUND = 1e-3
# Variance of a value of which nothing but its bounds is known, in shares of the range.
_UNIFORM = 1.0 / 12.0
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
        """Relative deviations of the targets, (t,)."""
        value = np.array([t.value for t in self.problem.spec.targets])
        return np.asarray(self.reached / value - 1.0)

    @property
    def met(self) -> bool:
        """Whether every target is reached within its tolerance."""
        tolerance = np.array([t.tolerance for t in self.problem.spec.targets])
        return bool((np.abs(self.deviations) <= tolerance).all())


def sensitivities_per_range(found: Identification) -> FloatArray:
    """Return d ln(target)/d(parameter/(upper - lower)) at the result, (t, n)."""
    tolerance = np.array([t.tolerance for t in found.problem.spec.targets])
    share = 1.0 + found.deviations
    return np.asarray(found.slopes * (tolerance / share)[:, None])


def relative_sensitivities(found: Identification) -> FloatArray:
    """Return d ln(target)/d ln(parameter) at the result, (t, n)."""
    parameters = found.problem.spec.parameters
    span = np.array([p.upper - p.lower for p in parameters])
    value = np.array([found.values[p.name] for p in parameters])
    return np.asarray(sensitivities_per_range(found) * value / span)


def uncertainties(found: Identification) -> FloatArray:
    """Return the standard deviation that the data leave each parameter, (n,), its own unit.

    Each target is taken as known to its tolerance, each parameter beforehand as evenly spread
    over its bounds, and the model as linear: 0.29 of the range says that the data tell nothing.
    """
    spec = found.problem.spec
    span = np.array([p.upper - p.lower for p in spec.parameters])
    information = found.slopes.T @ found.slopes + np.eye(len(span)) / _UNIFORM
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))) * span)


def document(found: Identification) -> dict[str, Any]:
    """Everything about an identification as plain data."""
    problem = found.problem
    _, singular, right = np.linalg.svd(found.slopes)
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
            "targets": [t.name for t in problem.spec.targets],
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
        "search": _search(found),
        "packages": package_versions(),
    }


def _targets(found: Identification) -> list[dict[str, Any]]:
    return [
        {
            **t.model_dump(exclude={"tolerance"}),
            "reached": float(reached),
            "deviation_percent": float(100.0 * deviation),
            "tolerance_percent": 100.0 * t.tolerance,
            "met": bool(abs(deviation) <= t.tolerance),
        }
        for t, reached, deviation in zip(
            found.problem.spec.targets, found.reached, found.deviations, strict=True
        )
    ]


def _parameters(found: Identification) -> list[dict[str, Any]]:
    spread = uncertainties(found)
    return [
        {
            "name": p.name,
            "value": found.values[p.name],
            "plus_minus": float(spread[k]),
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
    """Yield a line per parameter: its value, what the targets leave open, and its bounds."""
    for p in _parameters(found):
        bound = f", at its {p['at_bound']} bound" if p["at_bound"] else ""
        yield (
            f"{p['name']} = {p['value']:.6g} ± {p['plus_minus']:.2g} "
            f"({p['lower']:g} to {p['upper']:g}{bound})"
        )


def missed_lines(found: Identification) -> Iterator[str]:
    """Yield a line per target that is not reached within its tolerance."""
    for t in _targets(found):
        if not t["met"]:
            yield (
                f"{t['name']}: {t['reached']:.6g} instead of {t['value']:g}, "
                f"{t['deviation_percent']:+.2f} % where {t['tolerance_percent']:g} % is allowed"
            )
