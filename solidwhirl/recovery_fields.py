"""Fields of the bodies of a run, made when a recovery asks for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from solidwhirl.body_reduction import BodyResult, request_of
from solidwhirl.body_stages import Job


def recoveries_of(job: Job, reduced: Mapping[str, BodyResult]) -> Callable[[str], Any]:
    """Return a function that makes the recovery of a body by its name, once for each.

    Parameters
    ----------
    job
        The run.
    reduced
        Its bodies that were meshed.
    """

    @cache
    def recovery(name: str) -> Any:
        from solidwhirl.reduction.fields import body_fields
        from solidwhirl.reduction.stresses import StressRecovery

        found = reduced[name]
        request = request_of(job.scene, job.plan, found.body, found.discretisation)
        job.progress(f"reduce {name} again, for its fields")
        return StressRecovery(body_fields(found.body, found.mesh, request, found.element))

    return recovery
