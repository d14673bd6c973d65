"""Bounded nonlinear least squares over the parameters of an identification problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from solidwhirl.identify.model import BudgetError, InfeasibleError, Model, Progress
from solidwhirl.rotordyn.core.arrays import BoolArray, FloatArray

Function = Callable[[FloatArray], FloatArray]
# Finite difference of closed forms, share of a range: truncation and round-off are both small.
_MASS_STEP = 1e-3
# Where one side has no model, the difference is taken to the other side, then nearer.
_TRIED_STEPS = (1.0, -1.0, 0.2, -0.2)
# Relative change of the cost and step in shares of the ranges at which a search ends, and the
# largest deviation in tolerances at which it need not go on.
_COST_CHANGE, _STEP_CHANGE, _GOOD = 1e-3, 1e-5, 0.2
# Measurements want the least sum itself: a part of a standard deviation matters.
_COST_CHANGE_MEASURED = 1e-6
_MAXIMUM_STEPS = 100


@dataclass(frozen=True, kw_only=True, eq=False)
class Descent:
    """One search from one start."""

    point: FloatArray  # where it ended, in the unit cube, (n,)
    cost: float  # half the sum of squared residuals, prior included; inf if the start has no model
    largest: float  # largest deviation of a target in units of its tolerance
    ended: str  # why it ended


class _ReachedError(Exception):
    """All targets are met well within their tolerances."""


def search(model: Model, progress: Progress) -> tuple[Descent, tuple[Descent, ...]]:
    """Search from all starts with the coarse model, then with the fine one from the best.

    Returns the last descent, and those of all starts.
    Raises InfeasibleError: no start has a model; the message repeats that of the first one.
    """
    settings = model.problem.spec.settings
    starts = start_points(model)
    done: list[Descent] = []
    for k, start in enumerate(starts):
        progress(f"start {k + 1} of {len(starts)}")
        try:
            near = _mass_stage(model, start)
            done.append(_descend(model, near, settings.coarse_accuracy))
        except InfeasibleError as error:
            done.append(Descent(point=start, cost=np.inf, largest=np.inf, ended=str(error)))
        if done[-1].ended == "budget":
            break
    best = min(done, key=lambda d: d.cost)
    if not np.isfinite(best.cost):
        raise InfeasibleError(f"no start of the search has a model: {model.infeasible[0]}")
    if not model.problem.needs_model or done[-1].ended == "budget":
        return best, tuple(done)
    progress(f"refine at accuracy {settings.accuracy:g}")
    try:
        return _descend(model, best.point, settings.accuracy), tuple(done)
    except InfeasibleError as error:
        return replace(best, ended=f"not refined: {error}"), tuple(done)


def start_points(model: Model) -> FloatArray:
    """Return the starts in the unit cube: the given one, then a Latin hypercube by the seed."""
    from scipy.stats import qmc  # takes a fifth of a second

    settings, given = model.problem.spec.settings, model.given
    if settings.starts == 1:
        return given[None]
    sampler = qmc.LatinHypercube(d=len(given), seed=settings.seed)
    return np.vstack([given, sampler.random(settings.starts - 1)])


def measured_slopes(model: Model, point: FloatArray) -> FloatArray:
    """Return d(deviation in tolerances)/d(point) by finite differences, (rows, n).

    Mass properties are differentiated with a small step in closed form, the others on the coarse
    model with the problem's step, which is large against the scatter between meshes (about 1e-4).

    Raises InfeasibleError: no neighbour of the point has a model.
    """
    slopes = _differences(lambda u: model.deviations(model.masses(u)), point, _MASS_STEP)
    modelled = ~model.mass_rows
    if modelled.any():
        settings = model.problem.spec.settings
        whole = _differences(
            lambda u: model.deviations(model.whole(u, settings.coarse_accuracy)),
            point,
            settings.step,
        )
        slopes[modelled] = whole[modelled]
    return slopes


def _differences(function: Function, point: FloatArray, step: float) -> FloatArray:
    """One-sided differences within the unit cube; where one side has no model, the other."""
    here = function(point)
    return np.array([_column(function, point, here, k, step) for k in range(len(point))]).T


def _column(
    function: Function, point: FloatArray, here: FloatArray, k: int, step: float
) -> FloatArray:
    for h in (step * share for share in _TRIED_STEPS):
        there = point.copy()
        there[k] += h
        if 0.0 <= there[k] <= 1.0:
            try:
                return np.asarray((function(there) - here) / h)
            except InfeasibleError:
                continue
    raise InfeasibleError(
        f"parameter {k + 1}: no model on either side of a value that was reached, so the slopes "
        "there are unknown; narrow the bounds"
    )


def _mass_stage(model: Model, start: FloatArray) -> FloatArray:
    """Meet the mass properties near a start, before anything is meshed."""
    rows = model.mass_rows & model.fit_rows
    if not (model.problem.needs_model and rows.any()):
        return start

    def closed_forms(point: FloatArray) -> FloatArray:
        return model.deviations(model.masses(point))

    def slopes(point: FloatArray) -> FloatArray:
        return _differences(closed_forms, point, _MASS_STEP)

    return _walk(model, closed_forms, slopes, start, centre=start, rows=rows).point


def _descend(model: Model, start: FloatArray, accuracy: float) -> Descent:
    """Least squares of all targets, from a point that has a model."""
    return _walk(
        model,
        lambda point: model.deviations(model.whole(point, accuracy)),
        lambda point: measured_slopes(model, point),
        start,
        centre=model.given,
        rows=model.fit_rows,
    )


def _walk(
    model: Model,
    deviations: Function,
    slopes: Function,
    start: FloatArray,
    *,
    centre: FloatArray,
    rows: BoolArray,
) -> Descent:
    """Least squares of some targets, with a weak pull towards a centre for what they leave open."""
    weight, size = model.problem.prior, len(start)
    is_measured = model.problem.is_measured
    seen: list[tuple[float, FloatArray, float]] = []

    def residuals(point: FloatArray) -> FloatArray:
        try:
            found = deviations(point)[rows]
        except InfeasibleError:
            if not seen:
                raise
            return np.full(rows.sum() + size, np.inf)  # shortens the step
        every = np.concatenate([found, weight * (point - centre)])
        largest = float(np.abs(found).max())
        seen.append((0.5 * float(every @ every), point.copy(), largest))
        if largest < _GOOD and not is_measured:
            raise _ReachedError
        return np.asarray(every)

    ended = "converged"
    try:
        least_squares(
            residuals,
            np.clip(start, 1e-6, 1.0 - 1e-6),  # the method walks in the interior
            jac=lambda point: np.vstack([slopes(point)[rows], weight * np.eye(size)]),
            bounds=(0.0, 1.0),
            method="trf",
            ftol=_COST_CHANGE_MEASURED if is_measured else _COST_CHANGE,
            xtol=_STEP_CHANGE,
            gtol=None,
            max_nfev=_MAXIMUM_STEPS,
        )
    except _ReachedError:
        pass
    except BudgetError:
        ended = "budget"
    except InfeasibleError as error:
        if not seen:
            raise
        ended = str(error)
    if not seen:
        raise InfeasibleError("the evaluations were used up before the first one")
    cost, point, largest = min(seen, key=lambda s: s[0])
    return Descent(point=point, cost=cost, largest=largest, ended=ended)
