"""Bounded nonlinear least squares over the parameters of an identification problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.stats import qmc

from solidwhirl.identify_model import BudgetError, InfeasibleError, Model
from solidwhirl.identify_problem import is_mass_target

FloatArray = NDArray[np.float64]
Progress = Callable[[str], None]
Function = Callable[[FloatArray], FloatArray]
# Cost, point and residuals of the targets of every evaluation of a search.
_Seen = list[tuple[float, FloatArray, FloatArray]]
# Finite difference of closed forms, share of a range: truncation and round-off are both small.
_MASS_STEP = 1e-3
# Slopes are measured anew where they foretold the last step worse than by this share.
_TRUSTED = 0.3
# Tolerances of the search: relative change of the cost, step in shares of the ranges.
_COST_CHANGE, _STEP_CHANGE = 1e-3, 1e-5
_MAXIMUM_STEPS = 100
# Largest deviation in tolerances at which a search need not go on.
_GOOD = 0.2
# A search that ends this near to where its slopes were measured, in shares of the ranges, is done.
_STANDING = 2e-3
# Steps without gain after which updated slopes are measured anew.
_FAILURES = 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Descent:
    """One search from one start.

    Attributes
    ----------
    start, point
        Where it began and ended, in the unit cube, (n,).
    cost
        Half the sum of squared residuals, prior included; inf if the start has no model.
    largest
        Largest deviation of a target in units of its tolerance.
    slopes
        d(residuals of the targets)/d(point), (targets, n).
    ended
        Why it ended.
    """

    start: FloatArray
    point: FloatArray
    cost: float
    largest: float
    slopes: FloatArray | None
    ended: str


def search(model: Model, progress: Progress) -> tuple[Descent, tuple[Descent, ...]]:
    """Search from all starts on the coarse level, then on the fine one from the best.

    Parameters
    ----------
    model
        Gives the quantities, and counts.
    progress
        Called with one line per stage.

    Returns
    -------
    Descent, tuple of Descent
        The last one, and those of all starts.

    Raises
    ------
    InfeasibleError
        No start has a model; the message repeats that of the first one.
    """
    settings = model.problem.spec.settings
    starts = start_points(model)
    done: list[Descent] = []
    for k, start in enumerate(starts):
        progress(f"start {k + 1} of {len(starts)}")
        done.append(_from_start(model, start))
        if done[-1].ended == "budget":
            break
    best = min(done, key=lambda d: d.cost)
    if not np.isfinite(best.cost):
        raise InfeasibleError(f"no start of the search has a model: {model.infeasible[0]}")
    if not model.problem.needs_model or done[-1].ended == "budget":
        return best, tuple(done)
    progress(f"refine at accuracy {settings.accuracy:g}")
    try:
        return _descend(model, best.point, settings.accuracy, best.slopes), tuple(done)
    except InfeasibleError as error:
        return replace(best, ended=f"not refined: {error}"), tuple(done)


def start_points(model: Model) -> FloatArray:
    """Return the starts in the unit cube: the given one, then a Latin hypercube by the seed."""
    parameters = model.problem.spec.parameters
    settings = model.problem.spec.settings
    given = model.point({p.name: p.start for p in parameters})
    if settings.starts == 1:
        return given[None]
    sampler = qmc.LatinHypercube(d=len(parameters), seed=settings.seed)
    return np.vstack([given, sampler.random(settings.starts - 1)])


def residuals(model: Model, quantities: FloatArray) -> FloatArray:
    """Return the deviations of the targets in units of their tolerances."""
    targets = model.problem.spec.targets
    value = np.array([t.value for t in targets])
    return np.asarray((quantities / value - 1.0) / np.array([t.tolerance for t in targets]))


def measured_slopes(model: Model, point: FloatArray) -> FloatArray:
    """Return d(residuals)/d(point) by finite differences on the coarse level, (targets, n).

    Mass properties are differentiated with a small step in closed form, the others with the
    problem's step, which is large against the scatter between meshes (about 1e-4).

    Raises
    ------
    InfeasibleError
        No neighbour of the point has a model.
    """
    slopes = _mass_slopes(model, point)
    modelled = ~_mass_rows(model)
    if modelled.any():
        settings = model.problem.spec.settings
        whole = _differences(
            lambda u: residuals(model, model.whole(u, settings.coarse_accuracy)),
            point,
            settings.step,
        )
        slopes[modelled] = whole[modelled]
    return slopes


def _from_start(model: Model, start: FloatArray) -> Descent:
    """Closed forms first, then the whole model on the coarse level."""
    try:
        near = _mass_stage(model, start)
        return _descend(model, near, model.problem.spec.settings.coarse_accuracy, None)
    except InfeasibleError as error:
        return Descent(
            start=start, point=start, cost=np.inf, largest=np.inf, slopes=None, ended=str(error)
        )


def _mass_rows(model: Model) -> NDArray[np.bool_]:
    return np.array([is_mass_target(t) for t in model.problem.spec.targets])


def _mass_slopes(model: Model, point: FloatArray) -> FloatArray:
    if not _mass_rows(model).any():
        return np.full((len(model.problem.spec.targets), len(point)), np.nan)
    return _differences(lambda u: residuals(model, model.masses(u)), point, _MASS_STEP)


def _differences(function: Function, point: FloatArray, step: float) -> FloatArray:
    """One-sided differences within the unit cube; where one side has no model, the other."""
    here = function(point)
    columns = []
    for k in range(len(point)):
        column = None
        for h in (step, -step, 0.2 * step, -0.2 * step):
            there = point.copy()
            there[k] += h
            if not 0.0 <= there[k] <= 1.0:
                continue
            try:
                column = (function(there) - here) / h
                break
            except InfeasibleError:
                continue
        if column is None:
            raise InfeasibleError(
                f"parameter {k + 1}: no model on either side of a value that was reached, so the "
                "slopes there are unknown; narrow the bounds"
            )
        columns.append(column)
    return np.array(columns).T


def _mass_stage(model: Model, start: FloatArray) -> FloatArray:
    """Meet the mass properties near a start, before anything is meshed."""
    rows = _mass_rows(model)
    if not (model.problem.needs_model and rows.any()):
        return start
    model.masses(start)
    prior = _Prior(model, start)

    def function(point: FloatArray) -> FloatArray:
        try:
            found = residuals(model, model.masses(point))[rows]
        except InfeasibleError:
            return np.full(rows.sum() + len(point), np.inf)
        return np.concatenate([found, prior.residuals(point)])

    def slopes(point: FloatArray) -> FloatArray:
        return np.vstack([_mass_slopes(model, point)[rows], prior.slopes])

    return _least_squares(function, slopes, start)


class _Prior:
    """Pull towards a point, weak beside the targets; it decides what the targets leave open."""

    def __init__(self, model: Model, centre: FloatArray) -> None:
        self._weight = model.problem.spec.settings.prior
        self._centre = centre
        self.slopes = self._weight * np.eye(len(centre))

    def residuals(self, point: FloatArray) -> FloatArray:
        return self._weight * (point - self._centre)


class _StaleError(RuntimeError):
    """Slopes that were only updated lead nowhere any more."""


class _Slopes:
    """Slopes of the targets along a search: measured, then updated by what each step shows.

    Between measurements the rows of the whole model follow Broyden's rank-one update; mass
    properties are differentiated at every point.
    """

    def __init__(self, model: Model, known: FloatArray | None) -> None:
        self._model = model
        self._rows = _mass_rows(model)
        self.last = known
        self.measured_at: FloatArray | None = None
        self._at: tuple[FloatArray, FloatArray] | None = None
        self._lowest = np.inf
        self._failures = 0

    def forget(self) -> None:
        """Measure at the next point."""
        self.last = self._at = None
        self._failures = 0

    def is_stale(self, cost: float) -> bool:
        """Whether steps with updated slopes keep failing; measured ones would be better."""
        self._failures = 0 if cost < self._lowest else self._failures + 1
        self._lowest = min(cost, self._lowest)
        measured = self._at is None or (
            self.measured_at is not None and np.array_equal(self.measured_at, self._at[0])
        )
        return not measured and self._failures >= _FAILURES

    def at(self, point: FloatArray, found: FloatArray) -> FloatArray:
        if self.last is None:
            self._measure(point)
        elif self._at is not None and not np.array_equal(point, self._at[0]):
            self._follow(point - self._at[0], found, self._at[1], point)
        self._at = (point.copy(), found)
        assert self.last is not None
        return self.last

    def _measure(self, point: FloatArray) -> None:
        self.last = measured_slopes(self._model, point)
        self.measured_at = point.copy()

    def _follow(
        self, step: FloatArray, found: FloatArray, before: FloatArray, point: FloatArray
    ) -> None:
        assert self.last is not None
        modelled = ~self._rows
        missed = found - (before + self.last @ step)
        poor = np.linalg.norm(missed[modelled]) > _TRUSTED * np.linalg.norm(before[modelled])
        # near the solution everything is small against the tolerances, scatter included
        if poor and np.abs(found).max() > _GOOD:
            self._measure(point)
            return
        updated = self.last + np.outer(missed, step) / (step @ step)
        updated[self._rows] = _mass_slopes(self._model, point)[self._rows]
        self.last = updated


def _descend(
    model: Model, start: FloatArray, accuracy: float, slopes: FloatArray | None
) -> Descent:
    """Least squares of all targets with the prior, from a point that has a model."""
    given = model.point({p.name: p.start for p in model.problem.spec.parameters})
    prior = _Prior(model, given)
    track = _Slopes(model, slopes)
    seen: _Seen = []

    def function(point: FloatArray) -> FloatArray:
        try:
            found = residuals(model, model.whole(point, accuracy))
        except InfeasibleError:
            return np.full(len(model.problem.spec.targets) + len(point), np.inf)
        all_residuals = np.concatenate([found, prior.residuals(point)])
        seen.append((0.5 * float(all_residuals @ all_residuals), point.copy(), found))
        if track.is_stale(seen[-1][0]):
            raise _StaleError
        return all_residuals

    def jacobian(point: FloatArray) -> FloatArray:
        found = next(f for _, p, f in reversed(seen) if np.array_equal(p, point))
        return np.vstack([track.at(point, found), prior.slopes])

    ended = "converged"
    try:
        model.whole(_inside(start), accuracy)  # refuses a start without a model
        _walk(track, seen, (function, jacobian), start)
    except BudgetError:
        ended = "budget"
    except InfeasibleError as error:
        if not seen:
            raise
        ended = str(error)
    if not seen:
        raise InfeasibleError("the evaluations were used up before the first one")
    cost, point, found = min(seen, key=lambda s: s[0])
    return Descent(
        start=start,
        point=point,
        cost=cost,
        largest=float(np.abs(found).max()),
        slopes=track.last,
        ended=ended,
    )


def _walk(
    track: _Slopes, seen: _Seen, problem: tuple[Function, Function], start: FloatArray
) -> None:
    """Least squares, with slopes measured anew where it stands still, until it is finished."""
    point = start
    while True:
        try:
            point = _least_squares(*problem, point)
        except _StaleError:
            point = min(seen, key=lambda s: s[0])[1]
        if _finished(track, seen, point):
            return
        track.forget()


def _finished(track: _Slopes, seen: _Seen, point: FloatArray) -> bool:
    """Whether a search that stands still does so with measured slopes, or is good enough."""
    found = next(f for _, p, f in reversed(seen) if np.array_equal(p, point))
    if np.abs(found).max() < _GOOD:
        return True
    return track.measured_at is not None and bool(
        np.abs(track.measured_at - point).max() < _STANDING
    )


def _inside(point: FloatArray) -> FloatArray:
    """The point, off the bounds: the method walks in the interior."""
    return np.clip(point, 1e-6, 1.0 - 1e-6)


def _least_squares(function: Function, slopes: Function, start: FloatArray) -> FloatArray:
    found = least_squares(
        function,
        _inside(start),
        jac=slopes,
        bounds=(0.0, 1.0),
        method="trf",
        ftol=_COST_CHANGE,
        xtol=_STEP_CHANGE,
        gtol=None,
        max_nfev=_MAXIMUM_STEPS,
    )
    return np.asarray(found.x)
