"""What solids of millions of unknowns need of a cluster, with a factorisation and without one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import scale_coefficients as measured
from scale_laws import ROADS, ScaleError, law

#: Part of the ideal speed-up that ranks reach, least and largest: assumptions from what is
#: published of MUMPS and of multigrid in solid mechanics (Adams, Bayraktar, Keaveny and
#: Papadopoulos, Proc. ACM/IEEE Supercomputing 2004), not measured here.
EFFICIENCY = {"direct": (0.2, 0.5), "iterative": (0.4, 0.8)}
#: Unknowns of a rank below which more ranks are no faster, as those efficiencies assume.
LEAST_OF_A_RANK = 20_000
# Part of a node's memory that a job may plan with.
_USABLE = 0.85
# Rows of a rank beyond which an index of 32 bits can not count the entries of its matrix.
_INDEX = 2**31


@dataclass(frozen=True, kw_only=True)
class Workload:
    """What the reduction of a solid asks of its solver.

    Attributes
    ----------
    setups
        Factorisations, or hierarchies.
    solutions
        Right-hand sides: constraint modes, their inertia, and three per column of the basis for the
        error estimate.
    eigensolutions
        Of `scale_coefficients.MODES` modes each.
    """

    setups: float = 2.0
    solutions: float = 100.0
    eigensolutions: float = 2.0


def solver_seconds(road: str, unknowns: float, work: Workload) -> tuple[float, float, float]:
    """Processor seconds of one core: expected, least and largest.

    Parameters
    ----------
    road, unknowns
        Of `ROADS`; that are solved for.
    work
        What is solved.
    """
    parts = (
        (work.setups, law(road, "setup_s")),
        (work.solutions, law(road, "static_s")),
        (work.eigensolutions, law(road, "modes_s")),
    )
    ranges = [(count * part.at(unknowns), *part.range_at(unknowns), count) for count, part in parts]
    expected = sum(r[0] for r in ranges)
    return expected, sum(r[3] * r[1] for r in ranges), sum(r[3] * r[2] for r in ranges)


def solver_gib(road: str, unknowns: float) -> tuple[float, float, float]:
    """Memory of a solver and its vectors on all ranks [GiB]: expected, least and largest.

    Parameters
    ----------
    road, unknowns
        Of `ROADS`; that are solved for.
    """
    found = law(road, "memory_gib")
    return found.at(unknowns), *found.range_at(unknowns)


@dataclass(frozen=True, kw_only=True)
class Cluster:
    """Nodes that are alike.

    Attributes
    ----------
    cores_per_node
        One rank on each at most.
    memory_per_node_gib
        Of a node.
    nodes
        There are.
    relative_speed
        Speed of one core, when all of the node compute, over that of the machine measured.
    """

    cores_per_node: int
    memory_per_node_gib: float
    nodes: int = 10_000
    relative_speed: float = 1.0

    def __post_init__(self) -> None:
        for name, value in (
            ("cores_per_node", self.cores_per_node),
            ("memory_per_node_gib", self.memory_per_node_gib),
            ("nodes", self.nodes),
            ("relative_speed", self.relative_speed),
        ):
            if not value > 0:
                raise ScaleError(f"{name} = {value:g}: must be above 0")


@dataclass(frozen=True, kw_only=True)
class ScaleRow:
    """One size on one road.

    Attributes
    ----------
    unknowns
        Solved for.
    road
        Of `ROADS`.
    memory_gib
        On all ranks, least and largest.
    first_node_gib
        What the mesh on rank 0 takes of its node's memory beside its share.
    nodes
        Least number whose memory holds the larger figure; None: the cluster has too few.
    ranks
        One per core of these nodes, but none with fewer than `LEAST_OF_A_RANK` unknowns.
    seconds
        Wall time of the solver's work on these nodes, least and largest; None without nodes.
    beyond
        Unknowns over those of the largest measurement.
    """

    unknowns: float
    road: str
    memory_gib: tuple[float, float]
    first_node_gib: float
    nodes: int | None
    ranks: int | None
    seconds: tuple[float, float] | None
    beyond: float


def reduction_gib(road: str, unknowns: float, ranks: int) -> tuple[float, float]:
    """Memory of a whole reduction on all ranks [GiB], least and largest.

    Parameters
    ----------
    road, unknowns
        Of `ROADS`; that are solved for.
    ranks
        Each brings the program itself.
    """
    _, least, largest = solver_gib(road, unknowns)
    others = measured.OTHERS_GIB * unknowns / 1e5 + ranks * measured.PROGRAM_GIB
    return least + others, largest * measured.RANKS_FACTOR[road] + others


def scale_table(
    unknowns: Sequence[float], cluster: Cluster, work: Workload | None = None
) -> tuple[ScaleRow, ...]:
    """Predict memory, nodes and time of solids on a cluster, on both roads.

    Parameters
    ----------
    unknowns
        Solved for; lateral motion of a solid from a profile leaves half of those of its mesh.
    cluster
        Its nodes.
    work
        What the reduction asks of its solver.

    Raises
    ------
    ScaleError
        No positive number of unknowns.
    """
    work = work or Workload()
    for n in unknowns:
        if not n > 0:
            raise ScaleError(f"unknowns = {n:g}: must be above 0")
    return tuple(_row(n, road, cluster, work) for n in unknowns for road in ROADS)


def factor_limit(cluster: Cluster, nodes: int) -> tuple[float, float]:
    """Unknowns whose reduction with a factorisation still fits nodes, least and largest.

    Parameters
    ----------
    cluster, nodes
        Its nodes, and how many of them; 0 where not even the program fits.
    """
    ranks = nodes * cluster.cores_per_node
    return _limit(cluster, nodes, ranks, 1), _limit(cluster, nodes, ranks, 0)


def equal_time(work: Workload | None = None) -> tuple[float, float, float]:
    """Unknowns from which the iteration takes less processor time: expected, least and largest.

    Parameters
    ----------
    work
        What is solved.
    """
    wanted = work or Workload()

    def faster(direct: int, iterative: int) -> float:
        return _first(
            lambda n: (
                solver_seconds("direct", n, wanted)[direct]
                > solver_seconds("iterative", n, wanted)[iterative]
            )
        )

    return faster(0, 0), faster(2, 1), faster(1, 2)


def scale_markdown(rows: Sequence[ScaleRow]) -> str:
    """Table of rows in Markdown."""
    head = ("solved for", "road", "memory [GiB]", "mesh on rank 0 [GiB]", "nodes", "ranks",
            "time", "beyond measured")  # fmt: skip
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    for r in rows:
        time = "does not fit" if r.seconds is None else f"{_time(r.seconds)}"
        cells = (f"{r.unknowns:.3g}", r.road, _range(r.memory_gib), f"{r.first_node_gib:.2g}",
                 r.nodes or "-", r.ranks or "-", time, f"{r.beyond:.3g} times")  # fmt: skip
        lines.append("| " + " | ".join(str(c) for c in cells) + " |")
    return "\n".join(lines) + "\n"


def _row(unknowns: float, road: str, cluster: Cluster, work: Workload) -> ScaleRow:
    mesh = measured.MESH_GIB * unknowns / 1e5
    nodes = _nodes(road, unknowns, cluster, mesh)
    ranks = None if nodes is None else _ranks(unknowns, cluster, nodes)
    seconds = None
    if ranks is not None:
        _, least, largest = solver_seconds(road, unknowns, work)
        speed = ranks * cluster.relative_speed
        poor, good = EFFICIENCY[road] if ranks > 1 else (1.0, 1.0)
        seconds = least / speed / good, largest / speed / poor
    return ScaleRow(
        unknowns=unknowns,
        road=road,
        memory_gib=reduction_gib(road, unknowns, ranks or 1),
        first_node_gib=mesh,
        nodes=nodes,
        ranks=ranks,
        seconds=seconds,
        beyond=unknowns / law(road, "memory_gib").largest,
    )


def _ranks(unknowns: float, cluster: Cluster, nodes: int) -> int:
    """Ranks on nodes: one per core, as far as each has enough to do."""
    return min(nodes * cluster.cores_per_node, max(1, int(unknowns // LEAST_OF_A_RANK)))


def _nodes(road: str, unknowns: float, cluster: Cluster, mesh: float) -> int | None:
    """Least number of nodes that hold a reduction, and on the first the mesh beside its share."""
    room = _USABLE * cluster.memory_per_node_gib

    def fits(nodes: int) -> bool:
        ranks = _ranks(unknowns, cluster, nodes)
        share = reduction_gib(road, unknowns, ranks)[1] / nodes
        return share + mesh <= room and measured.ROW_ENTRIES * unknowns / ranks < _INDEX

    if not fits(cluster.nodes):
        return None
    low, high = 0, cluster.nodes
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high


def _limit(cluster: Cluster, nodes: int, ranks: int, end: int) -> float:
    room = nodes * _USABLE * cluster.memory_per_node_gib
    if reduction_gib("direct", 1.0, ranks)[end] > room:
        return 0.0
    low, high = 1.0, 1e12
    for _ in range(80):
        middle = (low * high) ** 0.5
        fits = reduction_gib("direct", middle, ranks)[end] <= room
        low, high = (middle, high) if fits else (low, middle)
    return low


def _first(holds: Callable[[float], bool]) -> float:
    """Least size from which something holds; inf where it never does."""
    low, high = 1e3, 1e12
    if not holds(high):
        return float("inf")
    for _ in range(60):
        middle = (low * high) ** 0.5
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def _range(ends: tuple[float, float]) -> str:
    low, high = (f"{value:.2g}" if value < 99.5 else f"{value:.0f}" for value in ends)
    return low if low == high else f"{low} to {high}"


def _time(ends: tuple[float, float]) -> str:
    for unit, size in (("h", 3600.0), ("min", 60.0)):
        if ends[1] >= 2.0 * size:
            return f"{_range((ends[0] / size, ends[1] / size))} {unit}"
    return f"{_range(ends)} s"
