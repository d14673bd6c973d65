"""The tool that compares results of two trees: which side it tells to be right."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "tools"))

from truth_oracle import Dynamic
from truth_verdicts import Judge

# Of a unit mass on 1 + ω/2 N/m up to 2 rad/s: ω² = 1 + ω/2.
RIGHT = 0.25 + np.sqrt(1.0625)
NAMES = ("damping", "gyroscopic", "stiffness", "centrifugal_stiffness", "circulatory_stiffness")


def mass_on_a_table(roots):
    """A record of the modes of that mass at one speed."""
    rows = np.array([[np.eye(2), 2.0 * np.eye(2)]] * 2)
    law = {"kind": "frequency", "json": "{}", "ratio": 1.0, "mirrored": 0.0,
           "interpolation": "linear", "speeds": [0.0, 1.0], "frequencies": [0.0, 2.0],
           "k": rows, "c": 0.0 * rows, "m": 0.0 * rows}  # fmt: skip
    modes = {"values": np.array(roots), "real": np.zeros(0), "zeros": 0, "speed": 0.5}
    stored = {
        "kinds/top": 1.0,
        "matrices/mass": np.eye(1),
        "matrices/motions/j0": np.eye(2, 1),
        **{f"matrices/{name}": np.zeros((1, 1)) for name in NAMES},
        **{f"laws/j0/{key}": value for key, value in law.items()},
        **{f"modes/0.5/{key}": value for key, value in modes.items()},
    }
    return {key: np.asarray(value) for key, value in stored.items()}


@pytest.mark.parametrize(
    ("roots", "told"),
    [
        ([1j * RIGHT], []),
        ([], ["missed"]),
        ([1j * RIGHT, 1.5j], ["is no root"]),
        ([1j * RIGHT * (1 + 1e-7)], ["is no root", "missed"]),
        ([1j * RIGHT, 1j * RIGHT], ["lists"]),
    ],
)
def test_spoilt_results_are_told_and_which_side_is_right(roots, told):
    good, spoilt = mass_on_a_table([1j * RIGHT]), mass_on_a_table(roots)
    for pair, kind, who in (((good, spoilt), "worse", "new"), ((spoilt, good), "better", "old")):
        ((name, found),) = Judge(*pair, False).analyses()
        found = list(found)
        assert name == "modes/0.5" and [line.kind for line in found] == [kind] * len(told)
        assert all(f"{who} {t}" in line.text for t, line in zip(told, found, strict=True))


def test_what_both_missed_is_found():
    both = mass_on_a_table([])
    ((_, found),) = Judge(both, both, True).analyses()
    assert [line.text.split(" 1/s")[0] for line in found] == ["both missed 0+1.280776406j"]


def test_roots_under_a_table_over_the_frequency():
    oracle = Dynamic(mass_on_a_table([]))
    assert oracle.root(1j * RIGHT, 0.5).is_root
    assert not oracle.root(1j * (RIGHT + 1e-6), 0.5).is_root
    values, _ = oracle.roots(0.5)
    np.testing.assert_allclose(values, [1j * RIGHT], atol=1e-12)
    assert oracle.index(1j * RIGHT, 0.5) == 1
