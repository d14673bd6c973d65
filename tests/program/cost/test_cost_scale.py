"""Laws of growth of both solvers of a solid against measurements, and what is made of them."""

from __future__ import annotations

import importlib
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from solidwhirl.cost.solver_coefficients import SOLVERS

BENCH = Path(__file__).resolve().parents[3] / "bench"
sys.path.insert(0, str(BENCH))
laws = importlib.import_module("scale_laws")
measured = importlib.import_module("scale_coefficients")
table = importlib.import_module("scale_table")
sys.path.remove(str(BENCH))
ROADS, THEORY, ScaleError = laws.ROADS, laws.THEORY, laws.ScaleError
law, power_law = laws.law, laws.power_law
Cluster, Workload = table.Cluster, table.Workload
reduction_gib, scale_table = table.reduction_gib, table.scale_table

NODES = Cluster(cores_per_node=64, memory_per_node_gib=256.0)
# Of a size twice the largest that was fitted. Timings of one machine under changing load; memory
# follows the mesh, whose shape changes a little with its size.
WITHIN = {
    "memory_gib": 1.35,
    "setup_s": 1.6,
    "static_s": 1.5,
    "modes_s": 1.5,
    "factor_entries": 1.2,
}


@pytest.mark.parametrize("name", THEORY)
def test_the_largest_size_is_predicted_from_the_others(name):
    road, _, quantity = name.partition(".")
    rows = measured.MEASURED[road]
    n, values = rows["solved"], rows[quantity]
    found = power_law(n[:-1], values[:-1], THEORY[name])
    assert n[-1] > 1.7 * n[-2]
    low, high = found.range_at(n[-1])
    assert low <= found.at(n[-1]) <= high
    assert abs(np.log(found.at(n[-1]) / values[-1])) < np.log(WITHIN[quantity])


@pytest.mark.parametrize("name", SOLVERS)
def test_the_program_has_these_laws(name):
    found = law(*name.split("."))
    np.testing.assert_allclose(SOLVERS[name], (found.value, found.power, found.theory), rtol=1e-5)


def test_a_power_law_is_found():
    n = np.array([1e4, 3e4, 2e5])
    found = power_law(n, 7.0 * (n / 1e5) ** 1.4, 4.0 / 3.0)
    assert found.power == pytest.approx(1.4)
    assert found.at(5e4) == pytest.approx(7.0 * 0.5**1.4)
    # ten times beyond the largest: both powers, and the mean in logarithms
    known = 7.0 * 2.0**1.4
    assert found.range_at(2e6) == pytest.approx((known * 10.0 ** (4.0 / 3.0), known * 10.0**1.4))
    assert found.at(2e6) == pytest.approx(known * 10.0 ** (0.5 * (1.4 + 4.0 / 3.0)))
    low, high = found.range_at(5e4)
    assert low == high


@pytest.mark.solver
def test_the_factor_gives_way_in_memory_and_time():
    from solidwhirl.reduction.operators.solver_choice import predicted_factor_bytes

    # what the reduction decides by is a fit of the same factors, rounded for other solids
    for n in (3e4, 1e5, 2e5):
        ratio = predicted_factor_bytes(int(n)) / (law("direct", "memory_gib").at(n) * 2.0**30)
        assert 0.7 < ratio < 2.0
    for n in (1e5, 1e6, 5e6, 5e7):
        direct, iterative = (reduction_gib(road, n, 1) for road in ROADS)
        assert iterative[1] < direct[1]
        assert direct[0] <= direct[1]
    # small bodies are solved faster with a factor
    work = [table.solver_seconds(road, 1e5, Workload())[0] for road in ROADS]
    assert work[0] < 0.5 * work[1]
    expected, least, largest = table.equal_time()
    assert max(measured.MEASURED["direct"]["solved"]) < least <= expected <= largest


def test_nodes_hold_what_they_are_chosen_for():
    rows = scale_table((5e6, 5e7), NODES)
    assert [(r.unknowns, r.road) for r in rows] == [(n, road) for n in (5e6, 5e7) for road in ROADS]
    for row in rows:
        if row.nodes is None:
            assert row.seconds is None
            continue
        room = 0.85 * NODES.memory_per_node_gib
        assert row.memory_gib[1] / row.nodes + row.first_node_gib <= room
        if row.nodes > 1:  # one less would not do
            fewer = row.nodes - 1
            assert row.memory_gib[1] / fewer + row.first_node_gib > 0.9 * room
        assert row.ranks <= row.nodes * NODES.cores_per_node
        assert row.unknowns / row.ranks >= 20_000
        assert row.seconds[0] <= row.seconds[1]
        assert row.beyond > 20.0
    # more memory takes fewer nodes, faster cores less time
    small = next(row for row in rows if row.road == "direct")
    large = scale_table((5e6,), replace(NODES, memory_per_node_gib=1024.0))
    assert next(row for row in large if row.road == "direct").nodes <= small.nodes
    fast = scale_table((5e6,), replace(NODES, relative_speed=2.0))
    quick = next(row for row in fast if row.road == "direct")
    np.testing.assert_allclose(quick.seconds, 0.5 * np.array(small.seconds))


def test_what_fits_no_node_is_said():
    tiny = Cluster(cores_per_node=2, memory_per_node_gib=16.0, nodes=1)
    rows = scale_table((5e7,), tiny)
    assert all(r.nodes is None and r.seconds is None for r in rows)
    assert table.scale_markdown(rows).count("does not fit") == 2
    low, high = table.factor_limit(tiny, 1)
    assert 1e5 < low <= high < 5e6
    for end, limit in zip((1, 0), (low, high), strict=True):
        assert reduction_gib("direct", limit, 2)[end] == pytest.approx(0.85 * 16.0, rel=1e-6)
    assert table.factor_limit(Cluster(cores_per_node=64, memory_per_node_gib=1.0), 1) == (0.0, 0.0)


@pytest.mark.parametrize("value", [0, -1])
def test_nonsense_is_refused(value):
    with pytest.raises(ScaleError, match=r"memory_per_node_gib = .*: must be above 0"):
        Cluster(cores_per_node=64, memory_per_node_gib=value)
    with pytest.raises(ScaleError, match=r"unknowns = .*: must be above 0"):
        scale_table((value,), NODES)
    with pytest.raises(ScaleError, match=r"'direct\.setup' is not known"):
        law("direct", "setup")
