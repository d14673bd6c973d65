"""What the assembled engine costs, from what it has to solve."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from solidwhirl.analyses.work import EngineKind, EngineSize, Work
from solidwhirl.cost import run_coefficients as measured
from solidwhirl.cost.stand_in import StandIn
from solidwhirl.model.imported_bodies import imported_element
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import SpeedLawSpec
from solidwhirl.scene.records import Scene

_COORDINATES = 100.0
#: Powers of the coordinates in `run_coefficients.UNITS`.
POWERS = (0, 2, 3)
_GIB = 1024.0**3
# Speeds that a diagram looks at beyond those asked for: meetings, beginnings, rest.
_LOOKED_AT = 8.0
# Kinds of speed laws whose forces depend on the frequency too.
_OF_FREQUENCY = ("frequency_table", "magnetic")
# Work of each of these speeds, and that of the estimates of errors, by how eigenproblems are solved
# (measured: the ledgers of bench/forecast.py).
_DIAGRAMS = {
    "hermitian": Work(eigenproblems=1.0),
    "damped": Work(eigenproblems=0.2, continued=0.8, factorisations=0.8),
    "damped with laws": Work(eigenproblems=0.8, continued=2.2, factorisations=2.4),
    "isotropic": Work(eigenproblems=0.2, continued=3.0, factorisations=0.2),
    "damped, whole": Work(eigenproblems=1.0, factorisations=0.8),
    "damped with laws, whole": Work(eigenproblems=1.0, factorisations=5.5),
    "isotropic, whole": Work(eigenproblems=6.7, factorisations=22.0),
    # critical speeds and unstable ranges come with the diagram
    "asymmetric": Work(eigenproblems=6.5),
    "periodic": Work(eigenproblems=1.0),
}
_ESTIMATES = {
    "hermitian": Work(eigenproblems=25.0, factorisations=20.0),
    "damped": Work(eigenproblems=36.0, continued=20.0, factorisations=56.0),
    "damped with laws": Work(eigenproblems=36.0, continued=25.0, factorisations=55.0),
    "isotropic": Work(eigenproblems=78.0, continued=35.0, factorisations=157.0),
    "damped, whole": Work(eigenproblems=45.0, factorisations=50.0),
    "damped with laws, whole": Work(eigenproblems=45.0, factorisations=50.0),
    "isotropic, whole": Work(eigenproblems=250.0),
}
# Matrices of the engine that are in memory at once, by the kind of its eigenproblems: damped ones
# have twice the size, those in the frame of a body some harmonics where supports are unlike.
_MATRICES = {
    "hermitian": 12.0,
    "damped": 40.0,
    "isotropic": 40.0,
    "asymmetric": 40.0,
    "periodic": 400.0,
}


def engine_size(
    plan: Plan, scene: Scene, sizes: Mapping[str, int], engine: StandIn | None
) -> EngineSize:
    """Return what the work of an engine depends on.

    `sizes`: coordinates of its bodies, reduced; `engine`: what stands in for it, if anything does.
    """
    coordinates = sum(sizes.values()) + simple_coordinates(plan, scene)
    parts = (1.0,) if engine is None else engine.parts(sizes)
    of_frequency = any(law.kind in _OF_FREQUENCY for law in _laws(scene))
    return EngineSize(
        kind=engine_kind(plan, scene),
        coordinates=coordinates,
        parts=tuple(part * coordinates for part in parts),
        whole=of_frequency or (engine is not None and engine.is_free),
        shafts=exciters(plan, scene),
        laws=plan.on("speed_dependent_bearings"),
        uneven=_uneven(scene),
        frequencies=_frequencies(scene),
        speed_ratios=scene.speed_ratios(),
        top_rad_s=float(np.max(plan.speeds_rad_s)),
        operating=scene.operating,
        bodies=len(plan.bodies) + len(scene.rigid_bodies) + len(scene.beams) + len(scene.imported),
    )


def _laws(scene: Scene) -> list[SpeedLawSpec]:
    """Speed laws of the bearings, one of several as often as they have it."""
    return [scene.speed_laws[b.speed_law] for b in scene.bearings if b.speed_law is not None]


def _frequencies(scene: Scene) -> int:
    """How many frequencies the tables of bearings have between them, at least 1."""
    tables = (law for law in _laws(scene) if law.kind == "frequency_table")
    return max(1, len({hertz for law in tables for hertz in law.frequency_hz}))


def _uneven(scene: Scene) -> bool:
    """Whether a bearing is stiffer in one direction than across it, at some speed."""
    laws = _laws(scene)
    if any(law.kind in _OF_FREQUENCY for law in laws):
        return True
    stiffnesses = [
        *(bearing.stiffness_n_per_m for bearing in scene.bearings),
        *(k for law in laws if isinstance(law, AbsoluteLaw) for k in law.table().stiffness_n_per_m),
    ]
    if any(xx != yy or xy != -yx for (xx, xy), (yx, yy) in stiffnesses):
        return True
    return any(law.kind == "polynomial" and law.stiffness_x != law.stiffness_y for law in laws)


def engine_kind(plan: Plan, scene: Scene) -> EngineKind:
    """How its eigenproblems are solved."""
    if plan.on("asymmetry"):
        return "periodic" if _uneven(scene) else "asymmetric"
    if not (plan.on("bearing_damping") or plan.on("internal_damping")):
        return "hermitian"
    alike = plan.on("speed_dependent_bearings") and not _uneven(scene)
    return "isotropic" if alike else "damped"


def exciters(plan: Plan, scene: Scene) -> int:
    """Different speeds at which unbalances turn."""
    if float(np.max(plan.speeds_rad_s)) == 0.0:
        return 0
    return len({abs(ratio) for ratio in scene.speed_ratios().values() if ratio})


def stage_works(plan: Plan, size: EngineSize, estimates: bool) -> dict[str, Work]:
    """What every run solves of its engine, by stage; `estimates`: whether errors are estimated."""
    looked_at = len(plan.speeds_rad_s) + _LOOKED_AT
    if size.shafts == 0:  # at rest nothing is followed
        found = {"campbell": Work(undamped=looked_at), "checks": Work(checks=1.0)}
        return found | ({"error_estimate": Work(undamped=4.0 * looked_at)} if estimates else {})
    how = _how(size)
    found = {"campbell": _DIAGRAMS[how].times(looked_at)}
    if size.kind in ("asymmetric", "periodic"):
        return found
    # unstable speeds are only sought where something can feed energy
    sought = Work(eigenproblems=looked_at) if size.laws else Work()
    found |= {
        "critical_speeds": size.search.times(size.shafts),
        "checks": sought.and_also(Work(checks=looked_at)),
    }
    # modes and critical speeds are followed from one model to the other
    return found | ({"error_estimate": _ESTIMATES[how]} if estimates else {})


def _how(size: EngineSize) -> str:
    """How modes are followed, by the keys of the work that takes."""
    kind = "damped with laws" if size.kind == "damped" and size.laws else size.kind
    return f"{kind}, whole" if size.whole and f"{kind}, whole" in _DIAGRAMS else kind


def seconds_of(work: Work, size: EngineSize) -> float:
    """Processor seconds of work in an engine, on the machine that the coefficients are of."""
    counts = unit_counts(work, size)
    return sum(n * _unit_s(name, sizes_solved(name, size)) for name, n in counts.items())


def sizes_solved(name: str, size: EngineSize) -> dict[int, float]:
    """Sums over the parts of an engine of the powers of their coordinates, in hundreds.

    A response is solved in the part that is loaded, about one of the parts.
    """
    share = len(size.parts) if name == "solve" else 1
    sums = {p: sum((n / _COORDINATES) ** p for n in size.parts) / share for p in POWERS}
    return {**sums, 0: 1.0}


def unit_counts(work: Work, size: EngineSize) -> dict[str, float]:
    """How many problems of each kind that `run_coefficients.UNITS` has there are in work."""
    return {
        f"eigenproblem.{size.kind}": size.frequencies * work.eigenproblems,
        "undamped": work.undamped,
        "continued": work.continued,
        "factorisation": work.factorisations,
        "solve": work.solves,
        "balance": work.balances,
        "step": work.steps,
        "check": work.checks,
        "result": work.results,
    }


def step_s(coordinates: float) -> float:
    """Seconds of one step of a part that is stepped by itself."""
    return _unit_s("step", {p: (coordinates / _COORDINATES) ** p for p in POWERS})


def _unit_s(name: str, sizes: Mapping[int, float]) -> float:
    """Seconds of one problem of a kind; `sizes`: by their powers in `run_coefficients.UNITS`."""
    return sum(c * sizes[p] for c, p in zip(measured.UNITS[name], POWERS, strict=True))


def memory_gib(work: Work, size: EngineSize) -> float:
    """Memory beside the program: matrices of the engine, and the numbers that are kept."""
    matrices = _MATRICES[size.kind] * size.coordinates**2
    return 8.0 * (matrices + work.values) / _GIB


def simple_coordinates(plan: Plan, scene: Scene) -> int:
    """Coordinates of beams, rigid and imported bodies, at most."""
    out = 6 * len(scene.rigid_bodies)
    for name, spec in scene.beams.items():
        carried = {m for place in spec.interfaces for m in plan.carried[f"{name}.{place}"]}
        nodes = len({*spec.stations_m, *spec.interfaces.values(), *(d.at_m for d in spec.disks)})
        out += nodes * len({"ux", "uy", "rx", "ry", *carried})
    return out + sum(imported_element(name, s).size for name, s in scene.imported.items())
