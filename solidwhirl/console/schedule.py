"""What a run has still to do and how long that takes, from its forecast and its clock."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from solidwhirl.core.stages import Stage, StageName

if TYPE_CHECKING:  # loads the mesher
    from solidwhirl.cost.forecast import Forecast
    from solidwhirl.cost.work import Cost
    from solidwhirl.model.plan_records import Plan

# The measured speed counts for half when this part of all that is predicted is over, or so many
# seconds: the first stages say little of the others.
_PRIOR, _PRIOR_S = 0.25, 0.5
# Of a stage this part is counted down second by second; the rest ever slower, and never to its end:
# a stage that lasts longer than foreseen is not over.
_EVEN = 0.7
# Time to go may rise by this part above the least that was said.
_RISE = 0.1


def run_steps(plan: Plan, expected: Forecast, *, pictures: bool) -> tuple[Stage, ...]:
    """Stages of a run in their order, with predicted times."""
    rounds = [expected.first, *([expected.last] if expected.last else [])]
    stages = [stage for cost in rounds for stage in _body_stages(plan, cost.bodies)]
    whole = rounds[-1].whole.seconds
    for k, stage in enumerate(stages):
        if stage.name is StageName.REDUCTION:  # the first one loads the solvers
            more = whole.get("import_solvers", 0.0)
            stages[k] = replace(stage, seconds=stage.seconds + more)
            break
    written = expected.writing
    drawing = written.pictures_s if pictures else 0.0
    after = whole.get("checks", 0.0)
    for cost in rounds[-1].bodies.values():  # theirs is part of their reduction
        after -= cost.seconds.get("error_estimate", 0.0)
    return (
        *stages,
        Stage(name=StageName.ASSEMBLY),
        Stage(name=StageName.CAMPBELL, seconds=whole["campbell"]),
        Stage(name=StageName.CRITICAL_SPEEDS, seconds=whole.get("critical_speeds", 0.0)),
        Stage(
            name=StageName.ERROR_ESTIMATES,
            seconds=max(after + whole.get("error_estimate", 0.0), 0.0),
        ),
        *(stage for name, _ in plan.analyses for stage in _analysis_stages(name, expected)),
        Stage(name=StageName.WRITING, seconds=written.files_s + written.page_s + drawing),
    )


def _body_stages(plan: Plan, costs: Mapping[str, Cost]) -> Iterator[Stage]:
    for name, cost in costs.items():
        if plan.bodies[name].level == "beam":  # made without a word
            continue
        meshing = cost.seconds.get("meshing", 0.0)
        yield Stage(name=StageName.MESHING, body=name, seconds=meshing)
        yield Stage(name=StageName.REDUCTION, body=name, seconds=cost.total_s - meshing)


def _analysis_stages(name: str, expected: Forecast) -> Iterator[Stage]:
    cost = expected.analyses[name]
    own = cost.seconds - cost.parts * cost.part_s
    yield Stage(name=StageName.ANALYSIS, body=name, seconds=own)
    of_one = Stage(name=StageName.NODAL_DIAMETER, body=cost.body, seconds=cost.part_s)
    yield from [of_one] * cost.parts


class Schedule:
    """The stages of a run: those that are over, the one that runs, those to come.

    Stages that were foreseen and are skipped (kept from an earlier run, or not needed) count no
    more; one that was not foreseen is taken to last as long as it did when it came before. The
    times to come are multiplied by how much slower the stages were that are over than predicted.
    The time to go never rises by more than a tenth: what turns out to be more than was said stands
    until the time has caught up with it.

    `now`: clock [s].
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._start = now()
        self._coming: list[Stage] = []
        self._current: Stage | None = None
        self._began = self._start
        self._over: dict[Stage, float] = {}
        self._predicted_s = self._measured_s = 0.0
        self._prior_s = _PRIOR_S
        self._least = math.inf
        self._share = 0.0

    def foresee(self, stages: Sequence[Stage]) -> None:
        """Say what comes, in its order."""
        self._coming = list(stages)
        self._prior_s = max(_PRIOR_S, _PRIOR * sum(stage.seconds for stage in stages))
        self._least = math.inf

    def begin(self, stage: Stage) -> tuple[Stage, float] | None:
        """Begin a stage, and give the one that is over by that with its time [s]."""
        ended = self.end()
        if stage in self._coming:
            at = self._coming.index(stage)
            predicted = self._coming[at].seconds
            self._coming = self._coming[at + 1 :]
        else:
            predicted = self._over.get(stage, 0.0) / self.slowness
        self._current = replace(stage, seconds=predicted)
        self._began = self._now()
        return ended

    def end(self) -> tuple[Stage, float] | None:
        """End the stage that runs; give it with its time [s], or None if there is none."""
        if self._current is None:
            return None
        spent = self._now() - self._began
        done, self._current = self._current, None
        self._over[done] = spent
        if done.seconds > 0.0:
            self._predicted_s += done.seconds
            self._measured_s += spent
        return done, spent

    @property
    def slowness(self) -> float:
        """Measured over predicted time; 1 before anything was measured."""
        return (self._measured_s + self._prior_s) / (self._predicted_s + self._prior_s)

    def to_go_s(self) -> float | None:
        """Time to go [s]; None while nothing is foreseen."""
        if not self._coming and self._current is None:
            return None
        left = self.slowness * sum(stage.seconds for stage in self._coming)
        if self._current is not None:
            left += _left_of(self.slowness * self._current.seconds, self._now() - self._began)
        left = min(left, (1.0 + _RISE) * self._least)
        self._least = min(self._least, left)
        return left

    def share(self) -> float:
        """Part of the whole time that is over, 0 to 1; never smaller than before."""
        left = self.to_go_s()
        if left is not None:
            spent = self._now() - self._start
            self._share = max(self._share, spent / (spent + left) if spent + left else 0.0)
        return self._share


def _left_of(expected: float, spent: float) -> float:
    """Time that a stage still takes [s], from what it was expected to take and has taken.

    Second by second at first, then a hyperbola with the same slope, which never ends.
    """
    even = _EVEN * expected
    rest = expected - even
    if spent <= even or rest <= 0.0:
        return max(expected - spent, 0.0)
    return rest**2 / (rest + spent - even)
