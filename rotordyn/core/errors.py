"""Errors of the rotordynamics stage; all are ValueError, so one `except` catches bad input."""

from __future__ import annotations


class SuperelementError(ValueError):
    """Signal a superelement, or its file, that contradicts itself or the format."""


class AssemblyError(ValueError):
    """Signal a set of rotors and bearings that does not fit together.

    `problems`: one sentence for each fault found; all of them are reported at once.
    """

    def __init__(self, problems: tuple[str, ...]) -> None:
        self.problems = problems
        lines = "".join(f"\n  - {problem}" for problem in problems)
        super().__init__(f"the system cannot be assembled:{lines}")


class AnalysisError(ValueError):
    """Signal an analysis asked for with arguments that have no meaning."""


class NoSteadyResponseError(AnalysisError):
    """Signal a point at an undamped resonance, where no steady response exists."""
