"""What a run has still to do and how long that takes, from its forecast and its clock."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # loads the mesher
    from solidwhirl.cost import Cost
    from solidwhirl.forecast import Forecast
    from solidwhirl.plan_records import Plan

# Seconds of stages that the forecast leaves out, on the machine that its laws were measured on.
# They only share out the bar: what a stage really takes is measured as it runs.
_ASSEMBLY_S, _ESTIMATES_S, _ANALYSIS_S = 0.05, 0.3, 0.4
_NUMBERS_S, _PICTURES_S, _PICTURE_S = 0.2, 2.0, 0.4
# How many predicted seconds have to be over before the measured speed counts for half.
_PRIOR_S = 0.5
# A stage that lasts longer than foreseen is taken to last this part of its time longer yet.
_LONGER = 0.1
# Beginnings of messages that begin a stage, whether it was foreseen or not.
_STAGES = (
    *("mesh ", "reduce ", "assemble ", "Campbell diagram", "critical speeds", "error estimates"),
    "write ",
)


@dataclass(frozen=True, kw_only=True)
class Step:
    """A stage that a run will say it begins.

    Attributes
    ----------
    text
        What it says.
    seconds
        Predicted time [s].
    """

    text: str
    seconds: float


def run_steps(plan: Plan, expected: Forecast, *, pictures: bool) -> tuple[Step, ...]:
    """Stages of a run in their order.

    Parameters
    ----------
    plan, expected
        What is run and what it will cost.
    pictures
        Whether pictures are drawn.
    """
    rounds = [expected.first, *([expected.last] if expected.last else [])]
    steps = [step for cost in rounds for step in _body_steps(plan, cost.bodies)]
    whole = rounds[-1].whole.seconds
    importing = whole.get("import_solvers", 0.0)
    for k, step in enumerate(steps):
        if step.text.startswith("reduce "):  # the first one loads the solvers
            steps[k] = Step(text=step.text, seconds=step.seconds + importing)
            break
    diagram, critical = whole.get("campbell", 0.0), whole.get("critical_speeds", 0.0)
    steps += [
        Step(text="assemble the system", seconds=_ASSEMBLY_S),
        Step(text=f"Campbell diagram at {len(plan.speeds_rad_s)} speeds", seconds=diagram),
        Step(text="critical speeds", seconds=critical),
        Step(text="error estimates", seconds=_ESTIMATES_S + diagram),
    ]
    steps += [Step(text=f"{n} ({kind})", seconds=_ANALYSIS_S) for n, kind in plan.analyses]
    drawing = _PICTURES_S + _PICTURE_S * len(plan.analyses) if pictures else 0.0
    steps.append(Step(text="write the results", seconds=_NUMBERS_S + drawing))
    return tuple(steps)


def _body_steps(plan: Plan, costs: Mapping[str, Cost]) -> Iterator[Step]:
    for name, cost in costs.items():
        level = plan.bodies[name].level
        if level == "beam":  # made without a word
            continue
        meshing = cost.seconds.get("meshing", 0.0)
        yield Step(text=f"mesh {name} ({level})", seconds=meshing)
        yield Step(text=f"reduce {name}", seconds=cost.total_s - meshing)


class Schedule:
    """The stages of a run: those that are over, the one that runs, those to come.

    Stages that were foreseen and are skipped (kept from an earlier run, or not needed) count no
    more; one that was not foreseen is taken to last as long as it did when it came before. The
    times to come are multiplied by how much slower the stages were that are over than predicted.

    Parameters
    ----------
    now
        Clock [s].
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._start = now()
        self._coming: list[Step] = []
        self._current: Step | None = None
        self._began = self._start
        self._over: dict[str, float] = {}
        self._predicted_s = self._measured_s = 0.0
        self._share = 0.0

    def foresee(self, steps: Sequence[Step]) -> None:
        """Say what comes.

        Parameters
        ----------
        steps
            In their order.
        """
        self._coming = list(steps)

    def is_stage(self, text: str) -> bool:
        """Whether a message begins a stage; if not, it is a remark."""
        return text.startswith(_STAGES) or any(step.text == text for step in self._coming)

    def begin(self, text: str) -> tuple[str, float] | None:
        """Begin a stage, and give the name and time [s] of the one that is over by that.

        Parameters
        ----------
        text
            What the run said.
        """
        ended = self.end()
        at = next((k for k, step in enumerate(self._coming) if step.text == text), None)
        if at is None:
            self._current = Step(text=text, seconds=self._over.get(text, 0.0) / self.slowness)
        else:
            self._current = self._coming[at]
            self._coming = self._coming[at + 1 :]
        self._began = self._now()
        return ended

    def end(self) -> tuple[str, float] | None:
        """End the stage that runs; give its name and time [s], or None if there is none."""
        if self._current is None:
            return None
        spent = self._now() - self._began
        done, self._current = self._current, None
        self._over[done.text] = spent
        if done.seconds > 0.0:
            self._predicted_s += done.seconds
            self._measured_s += spent
        return done.text, spent

    @property
    def slowness(self) -> float:
        """Measured over predicted time; 1 before anything was measured."""
        return (self._measured_s + _PRIOR_S) / (self._predicted_s + _PRIOR_S)

    def to_go_s(self) -> float | None:
        """Time to go [s]; None while nothing is foreseen."""
        if not self._coming and self._current is None:
            return None
        left = self.slowness * sum(step.seconds for step in self._coming)
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
