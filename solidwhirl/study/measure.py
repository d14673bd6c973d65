"""One case of a study in a process of its own: its results, processor time and peak memory."""

from __future__ import annotations

import logging
import multiprocessing
import os
import resource
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from solidwhirl.pipeline.run import Results, run_scene
from solidwhirl.rotordyn import Campbell, CriticalSpeed, campbell, critical_speeds
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene.records import Scene
from solidwhirl.study.cases import StudyCase

_STATUS = Path("/proc/self/status")
# Branches and speed range that the truth has more, so that those at the edge find their partners.
_MORE_BRANCHES, _MORE_HZ, _MORE_SPEED = 4, 1.3, 1.05


@dataclass(frozen=True, kw_only=True)
class Usage:
    """What a process has used since its start: processor time in s, peak memory in GiB."""

    cpu_s: float
    peak_memory_gib: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Measured:
    """Results and cost of a case."""

    #: unknowns, coordinates: of all bodies, before and after reduction
    unknowns: int
    coordinates: int
    bodies: Mapping[str, Mapping[str, int]]  #: Element order and number of modes by body
    #: startup, plain, estimated: used before the scene, by the end of a run without error
    #: estimates, and with them in its place; one of the last two is None where a case can not go
    #: without them or has none
    startup: Usage
    plain: Usage | None
    estimated: Usage | None
    wall_s: float  #: Wall time of the whole case
    #: campbell, critical_speeds: results; of the reference with a margin beyond the edge of its
    #: range
    campbell: Campbell
    critical_speeds: tuple[CriticalSpeed, ...]
    #: campbell_estimate, critical_estimate: estimated relative errors, (b, s) and (k,); empty for
    #: none
    campbell_estimate: FloatArray
    critical_estimate: FloatArray
    parts: Mapping[str, float]  #: Largest estimate by part

    @property
    def usage(self) -> Usage:
        """Cost that its error is held against: without estimates where it can go without."""
        found = self.plain or self.estimated
        assert found is not None
        return found


def usage(status: Path = _STATUS) -> Usage:
    """Return what this process has used.

    The status file of the kernel tells the peak memory of this program alone; without it that of
    getrusage is taken, which on some systems counts what the parent process had.
    """
    used = resource.getrusage(resource.RUSAGE_SELF)
    peak = used.ru_maxrss
    if status.is_file():
        lines = dict(
            line.partition(":")[::2] for line in status.read_text("ascii", "replace").splitlines()
        )
        peak = int(lines["VmHWM"].split()[0]) if "VmHWM" in lines else peak
    return Usage(cpu_s=used.ru_utime + used.ru_stime, peak_memory_gib=peak / 1024.0**2)


def measured(case: StudyCase) -> Measured:
    """Run a case in this process.

    Raises ValueError: what the scene can't be run for, and a level that is not there.
    """
    begun = time.perf_counter()
    if case.level != "beam":
        import solidwhirl.reduction  # noqa: F401  (part of the start, not of the first body)
    startup, plain, estimated = usage(), None, None
    if case.estimates != "on":
        results = _run(case.scene, "off")
        plain = usage()
    if case.estimates != "off":
        results = _run(case.scene, "on")
        estimated = usage()
    if plain is not None and estimated is not None:  # as if there had been the second run alone
        estimated = replace(estimated, cpu_s=estimated.cpu_s - plain.cpu_s + startup.cpu_s)
    truth = case.ladder == "reference"
    elements = [results.elements[name] for name in results.scene.bodies]
    errors = results.estimates if results.estimates and results.estimates.campbell.parts else None
    return Measured(
        unknowns=sum(e.full_dofs for e in elements),
        coordinates=sum(len(e.coordinates) for e in elements),
        bodies={
            name: {"element_order": r.discretisation.degree, "modes": r.discretisation.modes}
            for name, r in results.bodies.items()
        },
        startup=startup,
        plain=plain,
        estimated=estimated if errors else None,
        wall_s=time.perf_counter() - begun,
        campbell=_wider_diagram(results) if truth else results.campbell,
        critical_speeds=tuple(
            _wider_critical_speeds(results)
            if truth
            else [c.critical for c in results.critical_speeds]
        ),
        campbell_estimate=errors.campbell.total if errors else np.zeros((0, 0)),
        critical_estimate=errors.critical_speeds.total if errors else np.zeros(0),
        parts={
            part: float(np.nanmax(v))
            for part, v in (errors.campbell.parts if errors else {}).items()
            if np.isfinite(v).any()
        },
    )


def _run(scene: Scene, estimates: str) -> Results:
    model = scene.model.model_copy(update={"estimates": estimates})
    results = run_scene(scene.model_copy(update={"model": model}))
    assert results is not None  # one process
    for name in scene.bodies:
        level = results.elements[name].level
        if level != scene.model.level:
            raise ValueError(
                f"bodies.{name}: level {scene.model.level!r} was asked for and {level!r} was run"
            )
    return results


def _wider_diagram(results: Results) -> Campbell:
    """The diagram with some branches more, for others to be held against."""
    top, speeds = results.scene.campbell.frequency_max_hz, results.plan.speeds_rad_s
    if top is not None:
        return campbell(results.system, speeds, frequency_max_hz=_MORE_HZ * top)
    count = len(results.campbell.frequency_hz) + _MORE_BRANCHES
    return campbell(results.system, speeds, branch_count=count)


def _wider_critical_speeds(results: Results) -> list[CriticalSpeed]:
    """The critical speeds up to a little beyond the range."""
    top = _MORE_SPEED * float(results.plan.speeds_rad_s.max())
    if top == 0.0:
        return []
    top = min(top, results.system.speed_limit_rad_s)
    ratios = sorted({abs(r) for r in results.scene.speed_ratios().values() if r})
    return [
        c
        for ratio in ratios
        for c in critical_speeds(results.system, excitation_ratio=ratio, speed_max_rad_s=top)
    ]


def measured_apart(case: StudyCase, patience_s: float) -> Measured | str:
    """Run a case in a new process with one thread of linear algebra, ended after so long a time.

    Returns results and cost, or why there are none.
    """
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    process = context.Process(target=_tell, args=(case, theirs), daemon=True)
    with _one_thread():
        process.start()
    theirs.close()
    try:
        if not ours.poll(patience_s):
            return f"ended after {patience_s:.0f} s"
        answer: Measured | str = ours.recv()
    except EOFError:
        process.join()
        code = process.exitcode or 0
        memory = ", which is how a system ends programs when memory runs out" if code == -9 else ""
        return f"ended by signal {-code}{memory}" if code < 0 else f"ended with code {code}"
    finally:
        process.kill()
        process.join()
    return answer


def _tell(case: StudyCase, answer: Connection) -> None:
    """Send what a case gives, or the message of what is wrong with it."""
    logging.getLogger().setLevel(logging.WARNING)  # the form compiler talks at INFO level
    try:
        answer.send(measured(case))
    except (ValueError, ArithmeticError, MemoryError, np.linalg.LinAlgError) as error:
        answer.send(str(error) or type(error).__name__)


@contextmanager
def _one_thread() -> Iterator[None]:
    """Let processes that are started have one thread of linear algebra."""
    before = dict(os.environ)
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    try:
        yield
    finally:
        os.environ.clear()
        os.environ.update(before)
