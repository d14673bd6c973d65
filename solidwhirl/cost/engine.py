"""What the assembled engine costs, from what it has to solve."""

from __future__ import annotations

import numpy as np

from solidwhirl.analyses.work import EngineKind, EngineSize, Work
from solidwhirl.cost import run_coefficients as measured
from solidwhirl.model.imported_bodies import imported_element
from solidwhirl.model.plan_records import Plan
from solidwhirl.scene.bearing_physics import AbsoluteLaw
from solidwhirl.scene.joints import SpeedLawSpec
from solidwhirl.scene.records import Scene

_COORDINATES = 100.0
_GIB = 1024.0**3
# Speeds that a diagram looks at beyond those asked for: meetings, beginnings, rest.
_LOOKED_AT = 8.0
# Of each of these speeds, modes that are placed by themselves: where bearings follow the speed, and
# where they do not.
_PLACED, _PLACED_CONSTANT = 5.5, 0.8
# Eigenproblems of half the size for each of these speeds, placed modes among them.
_ALIKE = 15.0
# Matrices of the engine that are in memory at once, by the kind of its eigenproblems: damped ones
# have twice the size, those in the frame of a body some harmonics.
_MATRICES = {"hermitian": 12.0, "damped": 40.0, "isotropic": 40.0, "asymmetric": 400.0}


def engine_size(plan: Plan, scene: Scene, coordinates: int) -> EngineSize:
    """Return what the work of an engine depends on; `coordinates`: after its reduction."""
    return EngineSize(
        kind=engine_kind(plan, scene),
        coordinates=coordinates,
        shafts=exciters(plan, scene),
        laws=plan.on("speed_dependent_bearings"),
        uneven=_uneven(scene),
        frequencies=_frequencies(scene),
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
    if any(law.kind in ("frequency_table", "magnetic") for law in laws):
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
        return "asymmetric"
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
    if size.kind == "asymmetric":
        # critical speeds and unstable ranges come with the diagram
        return {"campbell": Work(eigenproblems=looked_at)}
    if size.kind == "isotropic":
        diagram = Work(eigenproblems=_ALIKE * looked_at)
        found = {
            "campbell": diagram,
            "critical_speeds": size.search.times(size.shafts),
            "checks": Work(checks=looked_at),
        }
        return found | (
            {"error_estimate": Work(eigenproblems=2.0 * _ALIKE * looked_at)} if estimates else {}
        )
    placed = _PLACED if size.laws else _PLACED_CONSTANT if size.kind == "damped" else 0.0
    diagram = Work(eigenproblems=looked_at, factorisations=placed * looked_at)
    found = {"campbell": diagram, "critical_speeds": size.search.times(size.shafts)}
    # unstable speeds are only sought where something can feed energy
    sought = Work(eigenproblems=1.1 * looked_at) if size.laws else Work()
    found["checks"] = sought.and_also(Work(checks=looked_at))
    if estimates:
        # modes and critical speeds are followed from one model to the other
        found["error_estimate"] = Work(eigenproblems=45.0, factorisations=50.0)
    return found


def seconds_of(work: Work, size: EngineSize) -> float:
    """Processor seconds of work in an engine, on the machine that the coefficients are of."""
    counts = unit_counts(work, size)
    return sum(count * unit_s(name, size.coordinates) for name, count in counts.items())


def unit_counts(work: Work, size: EngineSize) -> dict[str, float]:
    """How many problems of each kind that `run_coefficients.UNITS` has there are in work."""
    return {
        f"eigenproblem.{size.kind}": size.frequencies * work.eigenproblems,
        "undamped": work.undamped,
        "factorisation": work.factorisations,
        "solve": work.solves,
        "step": work.steps,
        "check": work.checks,
        "result": work.results,
    }


def unit_s(name: str, coordinates: float) -> float:
    """Seconds of one problem of a kind, see `run_coefficients.UNITS`."""
    n = coordinates / _COORDINATES
    once, square, cubic = measured.UNITS[name]
    return once + square * n**2 + cubic * n**3


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
