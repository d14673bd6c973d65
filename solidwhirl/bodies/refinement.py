"""Adaptive refinement: the bodies are discretised for the accuracy that a scene asks for.

Every iteration (round) reduces the bodies that changed, assembles the engine, estimates the errors
of the modes that the Campbell diagram will follow, at rest, at the top speed and between, and
refines what contributes more than its share: meshes by the errors of their own elements, bases by
more modes or another speed. Where the memory does not hold the next round, what it aims at is
doubled until it does, or nothing is left to refine. A round that turns out not to fit is given up.
Where that happens, or an estimate rises, the round before it counts. Analyses run once, on the
system of that round.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from solidwhirl.bodies.contributions import AskedModes, Contributions, error_contributions
from solidwhirl.bodies.reduction import BodyResult, Discretisation
from solidwhirl.core.errors import MemoryShortageError
from solidwhirl.geometry import Body
from solidwhirl.meshing import LocalSize, meridian_errors, refined_sector, refined_size
from solidwhirl.model.plan_records import Plan
from solidwhirl.rotordyn import AssembledSystem
from solidwhirl.rotordyn.core.arrays import FloatArray
from solidwhirl.scene.records import Scene

# Shares of the accuracy that the parts may use up; the rest is reserve.
_SHARES = {"mesh": 0.75, "mode_truncation": 0.2}
# What the next mesh or basis aims at, as a part of its share: estimates of one mesh foretell the
# next one to about that.
_AIM = 0.85
# Sizes at the edges of blades and the like decide for many tetrahedra beside them: the next
# estimate is 1.6 to 2.2 times what was aimed at (measured: bladed wheels, 1e-2 and 2e-3).
_AIM_OF_FEATURES = 0.5
# The error of a truncated basis falls about with this power of its number of modes.
_MODES_POWER = 4.0
_MOST_MODES = 500
# A mode that truncation changes by more is not there yet: its mesh error says nothing.
_LOST = 0.02
# Error between two speeds of the basis, beyond what it is at them, that calls for a third.
_BETWEEN = 0.1


@dataclass(frozen=True, kw_only=True)
class Round:
    """One iteration of the adaptive refinement."""

    unknowns: Mapping[str, int]
    modes: Mapping[str, int]
    estimate: float  #: Largest estimated relative error of the modes looked at
    parts: Mapping[str, float]
    refined: tuple[str, ...]  #: What was refined after it, such as "lp: mesh"
    #: Why nothing was refined though the accuracy is not met; empty where that is no matter
    stopped: str = ""
    #: Whether it was for memory, which another time there may be more of
    lacked_memory: bool = False
    kept: bool = False  #: Whether the results are of this round
    looked_at: int = 0  #: Modes that were looked at, over all speeds
    #: Whether it begins with meshes and bases that were refined for other supports or speeds
    from_other: bool = False


@dataclass(frozen=True, kw_only=True)
class Refinement:
    """What the refinement of the bodies of an engine came to."""

    discretisations: Mapping[str, Discretisation]
    rounds: tuple[Round, ...]


def next_discretisations(
    scene: Scene,
    plan: Plan,
    results: Mapping[str, BodyResult],
    system: AssembledSystem,
    accuracy: float,
) -> tuple[Round, Mapping[str, Discretisation]]:
    """Judge a round and choose what to refine for an accuracy.

    Returns round, changed: the record of the round and new discretisations of the bodies to be
    reduced again; empty when the accuracy is met or nothing can be refined.
    """
    found = error_contributions(system, sample_speeds(plan), asked_modes(scene))
    estimate = float(found.total.max(initial=0.0))
    changed: dict[str, Discretisation] = {}
    refined: list[str] = []
    # the mesh of a STEP file is compared when its basis is done, and has its share to come
    compared = any(None in plan.bodies[name].solved_orders for name in results)
    if estimate > accuracy * (_SHARES["mode_truncation"] if compared else 1.0):
        for name, result in results.items():
            chosen, what = _refined(accuracy, plan, found, result)
            if what:
                changed[name] = chosen
                refined += [f"{name}: {w}" for w in what]
    record = Round(
        unknowns={name: r.element.full_dofs for name, r in results.items()},
        modes={name: r.discretisation.modes for name, r in results.items()},
        estimate=estimate,
        parts={part: found.largest(part) for part in sorted({p for _, p in found.shares})},
        refined=tuple(refined),
        looked_at=len(found.rates),
    )
    return record, changed


Reduce = Callable[[str, Discretisation, BodyResult | None], BodyResult | None]
Judgement = tuple[Round, Mapping[str, Discretisation]]
Judge = Callable[[Mapping[str, BodyResult], int, float], Judgement | None]
Shortage = Callable[[Mapping[str, Discretisation], Mapping[str, BodyResult]], str]


def rounds_of(
    first: Mapping[str, Discretisation],
    reduce_one: Reduce,
    judge: Judge,
    comm: Any,
    most: int,
    shortage: Shortage = lambda todo, reduced: "",
    let_go: Callable[[BodyResult], BodyResult] = lambda result: result,
) -> tuple[dict[str, BodyResult], tuple[Round, ...]]:
    """Reduce bodies again until a judge has nothing more to refine, or it gets no better.

    Parameters
    ----------
    reduce_one
        Makes a body of a discretisation and its last result (None in the first round); None on
        ranks that have no part in the result.
    judge
        Record and next discretisations from the bodies, the number of the round, and how many
        times the accuracy is aimed at; None where there is nothing to judge.
    comm
        Communicator; its rank 0 decides.
    most
        Number of rounds after which it ends in any case.
    shortage
        Why the next discretisations are too much for the machine; empty where they are not.
    let_go
        Returns a body that is reduced again without what only its judge needed.

    Returns
    -------
    bodies, rounds
        Of the round with the smallest estimate, and the record of all.

    Raises
    ------
    MemoryShortageError
        Of the first round; a later one that raises it is given up.
    """
    todo = first
    best: dict[str, BodyResult] = {}
    rounds: list[Round] = []
    number = 0
    while todo:
        number += 1
        best |= {name: let_go(best[name]) for name in todo if name in best}
        reduced, given_up = dict(best), ""
        try:
            for name, chosen in todo.items():
                result = reduce_one(name, chosen, best.get(name))
                if result is not None:
                    reduced[name] = result
        except MemoryShortageError as error:
            if number == 1:
                raise
            reduced, given_up = best, str(error)
        found = judge(reduced, number, 1.0) if comm.rank == 0 and not given_up else None
        todo = {}
        if found is None:
            best = reduced
            if given_up and rounds:
                rounds[-1] = replace(rounds[-1], refined=(), stopped=given_up, lacked_memory=True)
        else:
            stopped, short = _stop(rounds, *found, most), ""
            if not stopped:
                again = partial(judge, reduced, number)
                found, short = _that_fits(found, again, shortage, reduced)
            stopped = stopped or short
            todo = {} if stopped else found[1]
            refined = () if stopped else found[0].refined
            rounds.append(
                replace(found[0], refined=refined, stopped=stopped, lacked_memory=bool(short))
            )
            best = best if _rises(rounds) else reduced
        todo = comm.bcast(todo, root=0)
    at = len(rounds) - 1 - _rises(rounds)
    return best, tuple(replace(r, kept=k == at) for k, r in enumerate(rounds))


def _that_fits(
    found: Judgement,
    judge: Callable[[float], Judgement | None],
    shortage: Shortage,
    reduced: Mapping[str, BodyResult],
) -> tuple[Judgement, str]:
    """The finest next round that fits, for the accuracy or a multiple of it; or why none does."""
    why, multiple, eased = shortage(found[1], reduced), 1.0, found
    short = why
    while short:
        multiple *= 2.0
        again = judge(multiple)
        if again is None or not again[1]:
            return found, why
        eased, short = again, shortage(again[1], reduced)
    return eased, ""


def _rises(rounds: Sequence[Round]) -> bool:
    """Whether the estimate of the last round is above that of the one before it.

    One that found more modes to look at, such as a larger basis has, has more to be wrong.
    """
    if len(rounds) < 2 or rounds[-1].looked_at > rounds[-2].looked_at:
        return False
    return not rounds[-1].estimate <= rounds[-2].estimate


def _stop(
    before: Sequence[Round], last: Round, todo: Mapping[str, Discretisation], most: int
) -> str:
    """Why a round is the last one though its judge would refine further."""
    if _rises([*before, last]):
        return "the estimate rises"
    if todo and len(before) + 1 >= most:
        return "one round" if most == 1 else f"{most} rounds"
    return ""


def sample_speeds(plan: Plan) -> tuple[float, ...]:
    """Speeds at which errors are looked at: first, last and one between [rad/s]."""
    low, high = float(plan.speeds_rad_s.min()), float(plan.speeds_rad_s.max())
    return tuple(sorted({low, float(np.sqrt(0.5 * (low**2 + high**2))), high}))


def asked_modes(scene: Scene) -> AskedModes:
    """Which modes the scene's Campbell diagram and its critical speeds ask for."""
    highest, count = scene.campbell.frequency_max_hz, scene.campbell.branches
    return AskedModes(
        count=count + count % 2 if highest is None else None,  # pairs are shown whole
        frequency_max_hz=highest,
        excitation_ratio=max((abs(r) for r in scene.speed_ratios().values()), default=0.0),
        rule=scene.criteria.rule,
    )


def _refined(
    accuracy: float, plan: Plan, found: Contributions, result: BodyResult
) -> tuple[Discretisation, list[str]]:
    """What one body changes: parts whose errors, all bodies together, exceed their share."""
    chosen = result.discretisation
    what: list[str] = []
    name = result.body.name
    if not chosen.mesh_fixed:
        allowed = _allowed(found, name, "mesh", accuracy)
        # asked last: indicators of a body that was kept cost its reduction
        if _own(found, name, "mesh") > allowed and result.work.indicators:
            aim = (
                _AIM_OF_FEATURES if isinstance(result.body, Body) and result.body.features else _AIM
            )
            chosen = _finer_mesh(found, result, chosen, aim * allowed)
            what.append("mesh")
    if not chosen.modes_fixed:
        allowed = _allowed(found, name, "mode_truncation", accuracy)
        own = _own(found, name, "mode_truncation")
        if own > allowed:
            between = _between(found, name, accuracy)
            if between and len(chosen.speeds_between_rad_s) < 3:
                top = plan.bodies[name].maximum_speed_rad_s
                chosen = replace(chosen, speeds_between_rad_s=_more_speeds(chosen, top))
                what.append("speed between")
            else:
                factor = np.clip((own / (_AIM * allowed)) ** (1.0 / _MODES_POWER), 1.2, 2.5)
                modes = min(int(np.ceil(chosen.modes * factor)), _MOST_MODES)
                if modes > chosen.modes:
                    chosen = replace(chosen, modes=modes)
                    what.append("modes")
    return chosen, what


def _own(found: Contributions, name: str, part: str) -> float:
    share = found.shares.get((name, part))
    return 0.0 if share is None else float(_trusted(found, share, part).max(initial=0.0))


def _trusted(found: Contributions, share: FloatArray, part: str) -> FloatArray:
    """Errors of a mesh, those of modes that the basis does not really have left out."""
    if part != "mesh":
        return share
    cut = [s for (_, p), s in found.shares.items() if p == "mode_truncation"]
    lost = np.sum(cut, axis=0) > _LOST if cut else np.zeros(len(share), dtype=bool)
    return np.where(lost, 0.0, share)


def _allowed(found: Contributions, name: str, part: str, accuracy: float) -> float:
    """A body's part of a part's share of the accuracy: as large as it is in the whole."""
    bodies = sum(_own(found, body, p) for body, p in found.shares if p == part)
    own = _own(found, name, part)
    return _SHARES[part] * accuracy * (own / bodies if bodies else 1.0)


def _between(found: Contributions, name: str, accuracy: float) -> bool:
    """Whether the error between the basis' speeds exceeds that at them noticeably."""
    share = found.shares.get((name, "mode_truncation"))
    if share is None or not len(share):
        return False
    speeds = np.unique(found.speeds_rad_s)
    if len(speeds) < 3:
        return False
    worst = [float(share[found.speeds_rad_s == v].max(initial=0.0)) for v in speeds]
    return worst[1] - max(worst[0], worst[-1]) > _BETWEEN * accuracy


def _more_speeds(chosen: Discretisation, top: float) -> tuple[float, ...]:
    """Speeds that divide Ω² evenly."""
    count = len(chosen.speeds_between_rad_s) + 1
    return tuple(float(top * np.sqrt(k / (count + 1))) for k in range(1, count + 1))


def _finer_mesh(
    found: Contributions, result: BodyResult, chosen: Discretisation, target: float
) -> Discretisation:
    """Sizes from the errors of the elements, worst modes counting most."""
    from solidwhirl.reduction.residuals.indicators import MotionSample

    name = result.body.name
    share = _trusted(found, found.shares[(name, "mesh")], "mesh")
    emphasis = (share / share.max()) ** 2
    form = next(f for f in result.element.error_forms if f.part == "mesh")
    samples = []
    for k in np.flatnonzero(emphasis > 1e-3):
        q, s, spin = found.motions[name][:, k], found.rates[k], found.spin_rad_s[name][k]
        spread = np.concatenate([q, s**2 * q, s * spin * q, spin**2 * q])
        energy = float((spread.conj() @ (form.gram @ spread)).real)
        if energy > 0.0:
            weight = float(emphasis[k] * share[k] / energy)
            samples.append(
                MotionSample(coordinates=q, s=complex(s), speed_rad_s=float(spin), weight=weight)
            )
    return replace(chosen, local=_local_size(result, chosen, samples, (float(share.max()), target)))


def _local_size(
    result: BodyResult,
    chosen: Discretisation,
    samples: Sequence[Any],
    errors_wanted: tuple[float, float],
) -> LocalSize:
    """Sizes from the errors of the elements in some motions.

    `samples`: `MotionSample` of them. `errors_wanted`: the largest error of the mesh as it is, and
    what it is to be.
    """
    from solidwhirl.reduction.residuals.indicators import element_errors

    indicators, body = result.work.indicators, result.body
    assert indicators is not None and isinstance(body, Body)  # given meshes are fixed
    orders = indicators()
    # all circumferential orders share the mesh
    parts = [element_errors(own, tuple(samples)) for own in orders]
    errors, points, cells = np.sum([p[0] for p in parts], axis=0), *parts[0][1:]
    found, target = errors_wanted
    errors = errors * (found / errors.sum())
    if body.features and cells.shape[1] == 4:
        singular = orders[0].finer.singular
        return refined_sector(
            chosen.size, points, cells, errors, singular, degree=chosen.degree, target=target
        )
    if cells.shape[1] == 4:
        points, cells, errors = meridian_errors(points, cells, errors)
    return refined_size(
        body,
        chosen.size,
        points,
        cells,
        errors,
        degree=chosen.degree,
        target=target,
        last=chosen.local,
    )
