"""What a run has still to do and how long that takes, from its forecast and its clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from solidwhirl.core.stages import Stage, StageName

if TYPE_CHECKING:  # loads the mesher
    from solidwhirl.cost.forecast import Forecast
    from solidwhirl.cost.work import Cost
    from solidwhirl.model.plan_records import Plan

# Seconds of stages that the forecast leaves out, on the machine that its laws were measured on.
# They only share out the bar: what a stage really takes is measured as it runs.
_ASSEMBLY_S, _ESTIMATES_S, _ANALYSIS_S = 0.05, 0.3, 0.4
_NUMBERS_S, _PICTURES_S, _PICTURE_S = 0.2, 2.0, 0.4
# How many predicted seconds have to be over before the measured speed counts for half.
_PRIOR_S = 0.5
# A stage that lasts longer than foreseen is taken to last this part of its time longer yet.
_LONGER = 0.1


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
    diagram, critical = whole.get("campbell", 0.0), whole.get("critical_speeds", 0.0)
    drawing = _PICTURES_S + _PICTURE_S * len(plan.analyses) if pictures else 0.0
    return (
        *stages,
        Stage(name=StageName.ASSEMBLY, seconds=_ASSEMBLY_S),
        Stage(name=StageName.CAMPBELL, seconds=diagram),
        Stage(name=StageName.CRITICAL_SPEEDS, seconds=critical),
        Stage(name=StageName.ERROR_ESTIMATES, seconds=_ESTIMATES_S + diagram),
        *(stage for name, _ in plan.analyses for stage in _analysis_stages(name, expected)),
        Stage(name=StageName.WRITING, seconds=_NUMBERS_S + drawing),
    )


def _body_stages(plan: Plan, costs: Mapping[str, Cost]) -> Iterator[Stage]:
    for name, cost in costs.items():
        if plan.bodies[name].level == "beam":  # made without a word
            continue
        meshing = cost.seconds.get("meshing", 0.0)
        yield Stage(name=StageName.MESHING, body=name, seconds=meshing)
        yield Stage(name=StageName.REDUCTION, body=name, seconds=cost.total_s - meshing)


def _analysis_stages(name: str, expected: Forecast) -> Iterator[Stage]:
    spent = expected.analyses.get(name, _ANALYSIS_S)
    yield Stage(name=StageName.ANALYSIS, body=name, seconds=spent)
    for own in expected.nodal_diameters:
        if own.analysis == name:
            of_one = Stage(name=StageName.NODAL_DIAMETER, body=own.body, seconds=own.seconds)
            yield from [of_one] * own.count


class Schedule:
    """The stages of a run: those that are over, the one that runs, those to come.

    Stages that were foreseen and are skipped (kept from an earlier run, or not needed) count no
    more; one that was not foreseen is taken to last as long as it did when it came before. The
    times to come are multiplied by how much slower the stages were that are over than predicted.

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
        self._share = 0.0

    def foresee(self, stages: Sequence[Stage]) -> None:
        """Say what comes, in its order."""
        self._coming = list(stages)

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
        return (self._measured_s + _PRIOR_S) / (self._predicted_s + _PRIOR_S)

    def to_go_s(self) -> float | None:
        """Time to go [s]; None while nothing is foreseen."""
        if not self._coming and self._current is None:
            return None
        left = self.slowness * sum(stage.seconds for stage in self._coming)
        if self._current is not None:
            spent = self._now() - self._began
            left += max(_LONGER * spent, self.slowness * self._current.seconds - spent)
        return left

    def share(self) -> float:
        """Part of the whole time that is over, 0 to 1; never smaller than before."""
        left = self.to_go_s()
        if left is not None:
            spent = self._now() - self._start
            self._share = max(self._share, spent / (spent + left) if spent + left else 0.0)
        return self._share
