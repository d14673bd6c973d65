"""Cyclic indices over the speed against the whole chain that they are cut from."""

from __future__ import annotations

import numpy as np
import pytest
from cyclic_chains import Chain
from scipy.optimize import brentq

from solidwhirl.rotordyn import AnalysisError
from solidwhirl.rotordyn import nodal_diameters as nd


@pytest.mark.parametrize("sectors", [5, 6, 7])
@pytest.mark.parametrize("speed", [0.0, 40.0, 95.0])
def test_the_indices_have_the_frequencies_of_the_whole(sectors, speed):
    chain = Chain(sectors=sectors)
    found = nd.nodal_diameter_modes(chain.body(), np.array([speed]), 2)
    rates = 2 * np.pi * np.concatenate([f.frequency_hz.ravel() for f in found.families])
    assert len(found.families) == sectors  # both directions where they differ
    assert np.sort(rates) == pytest.approx(chain.rates(speed), rel=1e-11)


def test_spin_parts_backward_and_forward_waves():
    """Equal at rest; at speed they part where no mirror plane makes them alike."""
    found = nd.nodal_diameter_modes(Chain(skew=0.0).body(), np.array([0.0, 60.0]), 2)
    back, fore = (found.family(2, d).frequency_hz for d in ("backward", "forward"))
    assert back[0] == pytest.approx(fore[0], rel=1e-12)
    assert np.abs(back[1] / fore[1] - 1.0).max() < 1e-12
    skewed = nd.nodal_diameter_modes(Chain().body(), np.array([60.0]), 2)
    back, fore = (skewed.family(2, d).frequency_hz for d in ("backward", "forward"))
    assert np.abs(back / fore - 1.0).min() > 1e-3


@pytest.mark.parametrize("order", [1, 2, 3, 4, 5, 6, 7, 9, 12, 13])
def test_an_engine_order_resonates_at_its_crossings(order):
    """The whole chain under the forces of the order, alias and direction not known to it."""
    chain = Chain()
    speeds = np.linspace(0.0, 130.0, 14)
    modes = nd.nodal_diameter_modes(chain.body(), speeds, 2)
    found = nd.engine_order_crossings(modes, [order])
    assert found
    at = np.array([crossing.speed_rad_s for crossing in found])
    near, aside = (chain.response(at * (1.0 + off), order) for off in (1e-7, 1e-3))
    assert (near > 1e3 * aside).all()
    # none is missing: the response has no other pole
    sampled = np.linspace(5.0, 130.0, 4001)
    size = chain.response(sampled, order)
    peaks = np.flatnonzero((size[1:-1] > size[:-2]) & (size[1:-1] > size[2:])) + 1
    high = sampled[peaks[size[peaks] > 20.0 * np.median(size)]]
    assert np.abs(high[:, None] - at).min(axis=1).max() < 0.07
    assert len(high) <= len(at)


def test_a_crossing_lies_on_its_branch():
    chain = Chain()
    speeds = np.linspace(0.0, 130.0, 27)
    modes = nd.nodal_diameter_modes(chain.body(), speeds, 2)
    for crossing in nd.engine_order_crossings(modes, range(1, 14)):
        index, direction = nd.excited_index(crossing.engine_order, 7)
        assert (index, direction) == (crossing.index, crossing.direction)
        branch = modes.family(index, direction).frequency_hz[:, crossing.mode]
        line = crossing.engine_order * speeds / (2 * np.pi)
        step = np.searchsorted(speeds, crossing.speed_rad_s)
        assert (branch - line)[step - 1] * (branch - line)[step] <= 0.0

        def apart(speed, index=index, direction=direction, crossing=crossing):
            own = nd.index_spectrum(chain.index(index), speed, direction).rates_rad_s
            return abs(own[crossing.mode]) - crossing.engine_order * speed

        root = brentq(apart, speeds[step - 1], speeds[step], xtol=1e-12)
        assert crossing.speed_rad_s == pytest.approx(root, rel=1e-10)


def test_engine_orders_fold_into_the_zigzag():
    expected = {1: (1, "backward"), 4: (4, "standing"), 5: (3, "forward"), 7: (1, "forward"),
                8: (0, "standing"), 9: (1, "backward"), 15: (1, "forward")}  # fmt: skip
    assert {e: nd.excited_index(e, 8) for e in expected} == expected
    assert nd.excited_index(11, None) == (11, "backward")
    line = nd.zigzag(5, 10, 2 * np.pi * 10.0)
    assert [2.5, 25.0] in line.tolist() and [2.5, 75.0] in line.tolist()
    assert line[np.isclose(line[:, 1], 70.0), 0] == pytest.approx(2.0)


def test_veering_and_crossing_are_told_apart():
    """Two oscillators whose tuning the spin changes: gap² = (slope Ω²)² + coupling²."""

    def body(coupling):
        stiffness = np.array([[1.0e4, coupling], [coupling, 1.0e4 + 900.0]])
        own = nd.CyclicMatrices(
            index=2,
            mass=np.eye(2),
            stiffness=stiffness,
            coriolis=np.zeros((2, 2)),
            centrifugal=np.diag([1.0, 0.0]),
        )
        return nd.CyclicBody(name="pair", sectors=8, indices=(own,))

    speeds = np.linspace(0.0, 60.0, 31)
    met = [
        nd.veerings(nd.nodal_diameter_modes(body(coupling), speeds, 2)) for coupling in (0.0, 25.0)
    ]
    (cross, _), (veer, _) = met  # backward and forward alike without Coriolis forces
    assert cross.kind == "crossing" and veer.kind == "veering"
    assert cross.speed_rad_s == pytest.approx(30.0, rel=1e-6)
    assert veer.speed_rad_s == pytest.approx(30.0, rel=2e-3)
    # equal diagonals 1.09e4: squares 1.09e4 ± 25
    exact = (np.sqrt(10925.0) - np.sqrt(10875.0)) / (2 * np.pi)
    assert veer.gap_hz == pytest.approx(exact, rel=1e-4)
    assert veer.exchanged > 0.95


def test_branches_keep_their_shape_through_a_crossing():
    own = nd.CyclicMatrices(
        index=0,
        mass=np.eye(2),
        stiffness=np.diag([1.0e4, 1.09e4]),
        coriolis=np.zeros((2, 2)),
        centrifugal=np.diag([1.0, 0.0]),
    )
    body = nd.CyclicBody(name="pair", sectors=8, indices=(own,))
    speeds = np.linspace(0.0, 60.0, 7)
    found = nd.nodal_diameter_modes(body, speeds, 2).family(0, "backward").frequency_hz
    assert found[:, 0] == pytest.approx(np.sqrt(1.0e4 + speeds**2) / (2 * np.pi))
    assert found[:, 1] == pytest.approx(np.sqrt(1.09e4) / (2 * np.pi))


def test_a_probe_that_stands_still_sees_the_free_wave_slower_or_faster():
    """A free ring of masses in inertial space: its backward wave of order h is ω - hΩ there."""
    hertz = np.array([100.0])
    speed = np.array([2 * np.pi * 30.0])
    assert nd.fixed_frame_hz(hertz, speed, 2) == pytest.approx([40.0])
    assert nd.fixed_frame_hz(-hertz, speed, 2) == pytest.approx([160.0])
    assert nd.fixed_frame_hz(hertz, speed, 2 - 12) == pytest.approx([400.0])


def test_residuals_estimate_the_error_of_a_reduced_index():
    """The chain's index in one coordinate, K-orthogonal answers left out, second order."""
    whole = Chain().index(2)
    energy = []
    for tilt in (0.02, 0.01):
        speed = 30.0
        spectrum = nd.index_spectrum(whole, speed, "backward")
        shape = spectrum.vectors[:, :1] + tilt * spectrum.vectors[:, 1:]
        matrices = [whole.stiffness, whole.mass, whole.coriolis, whole.centrifugal]
        terms = np.hstack([m @ shape for m in matrices])
        answers = np.linalg.solve(whole.stiffness, terms)
        inside = shape.conj().T @ terms / (shape.conj().T @ whole.stiffness @ shape)
        outside = answers - shape @ inside
        small = [shape.conj().T @ m @ shape for m in matrices]
        reduced = nd.CyclicMatrices(
            index=2, mass=small[1], stiffness=small[0], coriolis=small[2], centrifugal=small[3],
            omitted=(nd.OmittedEnergy(
                part="mode_truncation", gram=outside.conj().T @ whole.stiffness @ outside,
                safety=1.0, cutoff_rad_s=abs(float(spectrum.rates_rad_s[1])),
            ),),
        )  # fmt: skip
        body = nd.CyclicBody(name="one", sectors=7, indices=(reduced,))
        found = nd.nodal_diameter_modes(body, np.array([speed]), 1).family(2, "backward")
        true = found.frequency_hz[0, 0] * 2 * np.pi / spectrum.rates_rad_s[0] - 1.0
        assert found.error[0, 0] == pytest.approx(true, rel=0.35)
        energy.append(found.error[0, 0])
    assert energy[0] / energy[1] == pytest.approx(4.0, rel=0.05)


def test_a_body_without_stiffness_is_refused():
    own = nd.CyclicMatrices(
        index=3, mass=np.eye(1), stiffness=np.eye(1), coriolis=np.zeros((1, 1)),
        centrifugal=-np.eye(1),
    )  # fmt: skip
    body = nd.CyclicBody(name="soft", sectors=7, indices=(own,))
    with pytest.raises(AnalysisError, match=r"nodal diameter 3 .* 19\.0986 rpm"):
        nd.nodal_diameter_modes(body, np.array([0.0, 2.0]), 1)
    with pytest.raises(AnalysisError, match="from 1 on"):
        nd.engine_order_crossings(nd.nodal_diameter_modes(body, np.array([0.0, 0.5]), 1), [0])
    with pytest.raises(AnalysisError, match="stiffness is not Hermitian"):
        nd.CyclicMatrices(
            index=1, mass=np.eye(2), stiffness=np.array([[1.0, 1.0], [0.0, 1.0]]),
            coriolis=np.zeros((2, 2)), centrifugal=np.eye(2),
        )  # fmt: skip
