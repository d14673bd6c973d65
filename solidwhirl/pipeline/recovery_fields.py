"""Fields of the bodies of a run, made when a recovery asks for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from solidwhirl.bodies.reduction import BodyResult, request_of
from solidwhirl.core.stages import Stage, StageName
from solidwhirl.pipeline.body_stages import Job


def recoveries_of(job: Job, reduced: Mapping[str, BodyResult]) -> Callable[[str], Any]:
    """Return a function that makes the recovery of a body by its name, once for each."""

    @cache
    def recovery(name: str) -> Any:
        from solidwhirl.reduction.recovery.fields import body_fields
        from solidwhirl.reduction.recovery.stresses import StressRecovery

        found = reduced[name]
        request = request_of(job.scene, job.plan, found.body, found.discretisation)
        why = " again, for its fields"
        job.progress(Stage(name=StageName.REDUCTION, body=name, detail=why))
        return StressRecovery(body_fields(found.body, found.mesh, request, found.element))

    return recovery
