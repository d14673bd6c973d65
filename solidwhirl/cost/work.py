"""What a run will cost in unknowns, time and memory, from its plan alone.

The mesh is predicted from the element sizes (`meshing.own.prediction`), the time of every
stage from power laws of the unknowns that bench/scaling.py measures, and from what the engine has
to solve (`solidwhirl.cost.engine`). Times are processor seconds of one process; another machine is
faster or slower by a factor for each kind of work (`solidwhirl.cost.machine`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from solidwhirl.analyses.work import EngineSize
from solidwhirl.bodies.couplings import couplings_compared
from solidwhirl.bodies.reduction import first_discretisation
from solidwhirl.core.errors import UserError
from solidwhirl.cost import coefficients as measured
from solidwhirl.cost import run_coefficients as of_runs
from solidwhirl.cost.engine import engine_size, seconds_of, stage_works
from solidwhirl.cost.machine import REFERENCE, Machine
from solidwhirl.cost.solver_coefficients import LARGEST, MODES, SOLVERS
from solidwhirl.cost.stand_in import StandIn
from solidwhirl.geometry import Body
from solidwhirl.meshing.imported.records import MeshedBody
from solidwhirl.meshing.own.prediction import MeshKind, PredictedMesh, predict_mesh
from solidwhirl.model.plan_records import BodyPlan, Plan
from solidwhirl.model.resolution import Resolution
from solidwhirl.scene.records import Scene

#: Stages in the order of a run.
STAGES = (
    "start",
    "import_solvers",
    "meshing",
    "assembly",
    "contact",
    "factorisations",
    "static_solutions",
    "eigensolutions",
    "projection",
    "around",
    "error_estimate",
    "campbell",
    "critical_speeds",
    "checks",
)
_UNKNOWNS, _COLUMNS = 1e5, 10.0
_AXIAL = ("uz", "rz")
# What each circumferential order leaves in memory while the next one is solved.
_KEPT = 0.5
# Elements of a sector one order higher: GiB at 1e5 unknowns of the sector, and copies of the
# columns of the basis (measured: within 1.12 of seven runs, 12 to 60 blades, 2e4 to 2e5 unknowns).
_SECTOR_ESTIMATE = (1.5, 30.0)
# Beams: some milliseconds, whatever they are, and making their variants.
_BEAM_S, _BEAM_VARIANTS_S = 0.02, 0.4
# Diagrams of other models that estimates of beams compare with.
_VARIANTS = 8


class CostError(UserError):
    """A cost that can not be predicted."""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Predicted cost of one body, or of a run.

    `unknowns`: displacements before reduction, of all families and circumferential orders (as
    ``full_dofs`` in the results); `coordinates`: after reduction, at most; `seconds`: processor
    seconds by stage (see `STAGES`), without those that do not occur; `peak_memory_gib`: largest
    memory of the process, the program itself included; `extrapolated`: whether the unknowns are
    beyond what was measured.
    """

    unknowns: int
    coordinates: int
    seconds: Mapping[str, float]
    peak_memory_gib: float
    extrapolated: bool

    @property
    def total_s(self) -> float:
        """Sum over all stages [s]."""
        return sum(self.seconds.values())


@dataclass(frozen=True, kw_only=True)
class RunCost:
    """Predicted cost of a scene: of each body, without what they share, and of the whole.

    The whole is everything from the import of the solvers to the checks of the engine, without the
    [[analyses]], whose cost their own settings decide.
    """

    bodies: Mapping[str, Cost]
    whole: Cost
    size: EngineSize


def predict_body_cost(
    body: Body | MeshedBody,
    plan: BodyPlan,
    *,
    modes: int,
    estimates: bool = False,
    machine: Machine = REFERENCE,
    mesh: PredictedMesh | None = None,
) -> Cost:
    """Predict what meshing and reducing one body costs.

    `modes`: fixed-interface modes per order, pairs counted once; `estimates`: whether errors are
    estimated, that of the mesh of meridians and sectors only; `mesh`: None for that of the plan.

    One mesh and one reduction: if the mesh follows its error estimate, each round costs that of its
    own mesh, and this is the first.
    """
    if plan.level == "beam" and isinstance(body, Body):
        return _beam_cost(body, plan, modes)
    kind = mesh_kind(body, plan)
    if isinstance(body, MeshedBody):
        mesh = body.expected
    elif mesh is None:
        mesh = predict_mesh(body, resolution_of(plan).size, kind)
    problems = [_problem(plan, order, modes) for order in plan.solved_orders]
    once, times = of_runs.BODIES[body_kind(kind, plan)]
    factor = machine.factor("meridian" if kind == "harmonic" else "solid")
    given = isinstance(body, MeshedBody) and body.request.step is None
    seconds = {} if given else {"meshing": of_runs.MESHES * _meshing_s(kind, mesh)}
    for problem in problems:
        for stage, spent in _problem_s(kind, plan, mesh, problem, estimates).items():
            seconds[stage] = seconds.get(stage, 0.0) + times * spent
    seconds["around"] = once
    solved = mesh.unknowns(resolution_of(plan).degree)
    return Cost(
        unknowns=sum(p.families for p in problems) * solved,
        coordinates=sum(p.families * p.columns for p in problems),
        seconds={stage: factor * seconds[stage] for stage in STAGES if stage in seconds},
        peak_memory_gib=measured.BASE_GIB
        + (1.0 + _KEPT * (len(problems) - 1))
        * max(_memory_gib(kind, plan, mesh, p, estimates) for p in problems),
        extrapolated=solved > measured.LARGEST[kind],
    )


def predict_cost(
    plan: Plan,
    scene: Scene,
    bodies: Mapping[str, Body | MeshedBody],
    *,
    modes: Mapping[str, int],
    estimates: bool = False,
    machine: Machine = REFERENCE,
    meshes: Mapping[str, PredictedMesh] | None = None,
    engine: StandIn | None = None,
) -> RunCost:
    """Predict what a scene costs, from its plan.

    `modes`: fixed-interface modes of each solid; `meshes`: of bodies that have another one than
    their plan says; `engine`: what stands in for the assembled one (`solidwhirl.cost.stand_in`).
    """
    costs = {
        name: predict_body_cost(
            body,
            plan.bodies[name],
            modes=modes[name],
            estimates=estimates,
            machine=machine,
            mesh=(meshes or {}).get(name),
        )
        for name, body in bodies.items()
    }
    compared = couplings_s(plan, scene, bodies, machine) if estimates else 0.0
    size = engine_size(plan, scene, {n: c.coordinates for n, c in costs.items()}, engine)
    whole = _whole(plan, size, costs, machine, compared, estimates)
    return RunCost(bodies=costs, whole=whole, size=size)


def _whole(
    plan: Plan,
    size: EngineSize,
    costs: Mapping[str, Cost],
    machine: Machine,
    compared_s: float,
    estimates: bool,
) -> Cost:
    """Sum of the bodies, the solvers' import and what the assembled engine costs.

    `compared_s`: seconds of the couplings that estimates compare.
    """
    dense = machine.factor("dense")
    solids = any(plan.bodies[name].level != "beam" for name in costs)
    seconds = {"import_solvers": machine.factor("start") * of_runs.SOLVERS_S if solids else 0.0}
    for cost in costs.values():
        for stage, spent in cost.seconds.items():
            seconds[stage] = seconds.get(stage, 0.0) + spent
    for stage, work in stage_works(plan, size, estimates).items():
        seconds[stage] = seconds.get(stage, 0.0) + dense * seconds_of(work, size)
    if estimates:
        compared_s += _beams_compared_s(plan, seconds["campbell"], machine)
        seconds["error_estimate"] = seconds.get("error_estimate", 0.0) + compared_s
    return Cost(
        unknowns=sum(c.unknowns for c in costs.values()),
        coordinates=size.coordinates,
        seconds={stage: seconds[stage] for stage in STAGES if stage in seconds},
        # bodies are reduced one after another
        peak_memory_gib=max([measured.BASE_GIB, *(c.peak_memory_gib for c in costs.values())]),
        extrapolated=any(c.extrapolated for c in costs.values()),
    )


def _beams_compared_s(plan: Plan, diagram_s: float, machine: Machine) -> float:
    """Seconds of the beams that estimates compare with; `diagram_s`: of one diagram."""
    if all(own.level != "beam" for own in plan.bodies.values()):
        return 0.0
    return machine.factor("dense") * _BEAM_VARIANTS_S + _VARIANTS * diagram_s


def couplings_s(
    plan: Plan, scene: Scene, bodies: Mapping[str, Body | MeshedBody], machine: Machine
) -> float:
    """Seconds of the bodies that are reduced coarsely with either coupling of their interfaces."""
    if not plan.on("coupling_comparison"):
        return 0.0
    meshed = {n: b for n, b in bodies.items() if plan.bodies[n].level != "beam"}
    drawn = {n: b for n, b in meshed.items() if isinstance(b, Body)}
    pair = couplings_compared(scene, drawn)
    if pair is None:
        return 0.0
    costs = (
        predict_body_cost(
            body,
            pair.plan.bodies[name],
            modes=first_discretisation(pair.scene, pair.plan, name).modes,
            machine=machine,
        )
        for name, body in pair.as_is.items()
    )
    return 2.0 * of_runs.COMPARED * sum(cost.total_s for cost in costs)


def resolution_of(plan: BodyPlan) -> Resolution:
    """Return the mesh and element order of a body that has a mesh; CostError for a beam."""
    if plan.resolution is None:
        raise CostError(f"level {plan.level} has no mesh")
    return plan.resolution


def mesh_kind(body: Body | MeshedBody, plan: BodyPlan) -> MeshKind:
    """Kind of mesh, by which the laws of the cost differ."""
    if plan.level == "harmonic":
        return "harmonic"
    is_whole = isinstance(body, MeshedBody) or body.features or plan.shape == "asymmetric"
    return "solid" if is_whole else "revolved"


def body_kind(kind: MeshKind, plan: BodyPlan) -> str:
    """Key of a body in `run_coefficients.BODIES`; of a solid by what of it is meshed."""
    if kind != "solid":
        return kind
    if None not in plan.solved_orders:
        return "sector"
    return "asymmetric" if plan.shape == "asymmetric" else "whole"


@dataclass(frozen=True, kw_only=True)
class _Problem:
    """One circumferential order or index (None: the whole solid): sizes of what is solved."""

    order: int | None
    families: int
    interface_columns: int
    columns: int
    pairs: int


def _problem(plan: BodyPlan, order: int | None, modes: int) -> _Problem:
    """Columns of the basis, at most, and pairs that the eigenvalue solver is asked for."""
    carried = [c for motions in plan.interface_components.values() for c in motions]
    if order is None:
        interface, kept, pairs, families = len(carried), 2 * modes, 3 * modes + 4, 1
    elif order == 0:
        interface, families = sum(c in _AXIAL for c in carried), 1
        kept, pairs = modes, modes + 2
    else:
        interface, families = (len(carried) - sum(c in _AXIAL for c in carried)) // 2, 2
        kept, pairs = modes, modes + 2
    speeds = plan.eigenproblems // len(plan.solved_orders)
    return _Problem(
        order=order,
        families=families,
        interface_columns=interface,
        columns=2 * interface + speeds * kept,
        pairs=pairs,
    )


def _problem_s(
    kind: MeshKind, plan: BodyPlan, mesh: PredictedMesh, problem: _Problem, estimates: bool
) -> dict[str, float]:
    """Reference seconds of one circumferential order, by stage."""
    key, problems = f"{kind}.{resolution_of(plan).degree}", len(plan.solved_orders)
    unknowns = mesh.unknowns(resolution_of(plan).degree)
    eigen = plan.eigenproblems // problems
    # the first of several is that of the centrifugal field
    static = int(plan.factorisations // problems > 1)
    iterative = plan.solver == "iterative"
    if iterative:
        once = _solver("iterative.setup_s", unknowns)
        modes_s = problem.pairs / MODES * _solver("iterative.modes_s", unknowns)
    else:
        once = _law(f"{key}.factorisation", unknowns)
        modes_s = _law(f"{key}.eigensolutions", unknowns, problem.pairs)
    out = {
        "assembly": plan.matrices / problems * _law(f"{key}.assembly", unknowns),
        "factorisations": plan.factorisations / problems * once,
        "static_solutions": _solutions(key, unknowns, 2 * problem.interface_columns, iterative)
        + static * _solutions(key, unknowns, 1, iterative),
        "eigensolutions": eigen * modes_s,
        "projection": _law(f"{key}.projection", unknowns, problem.columns),
    }
    if mesh.pressed_edges:
        out["contact"] = _contact_s(key, resolution_of(plan).degree, mesh)
    if estimates:
        out["error_estimate"] = _estimate_s(kind, plan, mesh, problem)
    return out


def _contact_s(key: str, degree: int, mesh: PredictedMesh) -> float:
    """Seconds of the contact of pressed faces, which every order settles for itself.

    One factorisation without their springs, and a solution for every Gauss point of their edges:
    many, so that each takes as long as the next.
    """
    unknowns, points = mesh.unknowns(degree), (degree + 1) * mesh.pressed_edges
    once = _law(f"{key}.assembly", unknowns) + _law(f"{key}.factorisation", unknowns)
    return once + (points + 1) / _COLUMNS * _law(f"{key}.static_solutions", unknowns)


def _estimate_s(kind: MeshKind, plan: BodyPlan, mesh: PredictedMesh, problem: _Problem) -> float:
    """Seconds of the residual solves, and of elements one order higher.

    These are factorised on a meridian, and relaxed in a sector, whatever its elements are.
    """
    degree = resolution_of(plan).degree
    key, finer = f"{kind}.{degree}", f"{kind}.{degree + 1}"
    residuals, solved = 3 * problem.columns, mesh.unknowns(degree)
    spent = _solutions(key, solved, residuals, plan.solver == "iterative")
    if problem.order is None:
        return spent + _law(f"{key}.estimate", solved, problem.columns)
    if kind != "harmonic":
        return spent + _law(f"revolved.{degree}.estimate", solved, problem.columns)
    finer = finer if f"{finer}.factorisation" in measured.LAWS else key
    unknowns = mesh.unknowns(degree + 1)
    return (
        spent
        + _law(f"{key}.estimate", unknowns, problem.columns)
        + _law(f"{finer}.factorisation", unknowns)
        + _solutions(finer, unknowns, residuals + problem.interface_columns)
    )


def _law(name: str, unknowns: float, columns: float = _COLUMNS) -> float:
    """Seconds by a measured power law."""
    seconds, power, columns_power = measured.LAWS[name]
    if not unknowns or not columns:
        return 0.0
    return float(seconds * (unknowns / _UNKNOWNS) ** power * (columns / _COLUMNS) ** columns_power)


def _solutions(key: str, unknowns: float, columns: int, iterative: bool = False) -> float:
    """Seconds of solutions with a factor or a hierarchy at hand."""
    if iterative:
        return columns * _solver("iterative.static_s", unknowns)
    return _law(f"{key}.static_solutions", unknowns, columns)


def _solver(name: str, unknowns: float) -> float:
    """Seconds or GiB of a solver; beyond the measurements the mean of fitted and theoretical power.

    Factors of a solid under nested dissection have N^(4/3) entries (George, SIAM J. Numer. Anal. 10
    (1973) 345-363); multigrid is linear in all.
    """
    value, power, theory = SOLVERS[name]
    known = value * (min(unknowns, LARGEST) / _UNKNOWNS) ** power
    return float(known * max(unknowns / LARGEST, 1.0) ** (0.5 * (power + theory)))


def _meshing_s(kind: MeshKind, mesh: PredictedMesh) -> float:
    """Seconds of the mesher; every graded place is looked at for every element."""
    once, cell, place = measured.MESHING[kind]
    return once + mesh.cells * (cell + place * mesh.graded_places)


def _memory_gib(
    kind: MeshKind, plan: BodyPlan, mesh: PredictedMesh, problem: _Problem, estimates: bool
) -> float:
    """Memory of one order beyond the program: matrices and factors, vectors of the basis."""
    degree = resolution_of(plan).degree
    unknowns = mesh.unknowns(degree)
    estimated = estimates and problem.order is not None

    def law(name: str) -> tuple[float, float]:
        gib, power, copies = measured.MEMORY[name]
        return gib * (unknowns / _UNKNOWNS) ** power, copies

    if kind == "solid":
        # the solver alone was measured up to larger sizes
        solver = "iterative" if plan.solver == "iterative" else "direct"
        own, copies = law(f"{kind}.{degree}.reduction")
        alone = _solver(f"{solver}.memory_gib", unknowns)
        own = alone if solver == "iterative" else max(own, alone)
        if estimated:  # not at the same time
            finer, more = _SECTOR_ESTIMATE
            own, copies = max(own, finer * unknowns / _UNKNOWNS), max(copies, more)
    else:
        own, copies = law(f"{kind}.{degree}.{'estimate' if estimated else 'reduction'}")
    out = float(own + copies * 8.0 * unknowns * problem.columns / 1024.0**3)
    return of_runs.ASYMMETRIC_MEMORY * out if plan.shape == "asymmetric" else out


def _beam_cost(body: Body, plan: BodyPlan, modes: int) -> Cost:
    """Beams: one node per end of a section and interface, with all motions, and two planes."""
    nodes = len(body.sections) + len(body.interfaces) + 1
    carried = sum(len(motions) for motions in plan.interface_components.values())
    return Cost(
        unknowns=6 * nodes,
        coordinates=carried + 2 * modes,
        seconds={"assembly": _BEAM_S},
        peak_memory_gib=measured.BASE_GIB,
        extrapolated=False,
    )
