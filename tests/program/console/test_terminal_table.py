"""The table of critical speeds at the end of a run fits the terminal that it is printed on."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from solidwhirl.console.summary import fitting_table, long_margin


def entry(speed_rpm, margin, excited_by=("lp", "hp")):
    """A critical speed as the table takes it."""
    return {
        "speed_rpm": speed_rpm,
        "frequency_hz": speed_rpm / 60.0,
        "frequency_error_estimate": 1e-7,
        "whirl": "backward",
        "shares": {"lateral": 1.0, "torsional": 0.0, "axial": 0.0, "disk": 0.0},
        "shafts": list(excited_by),
        "excited": True,
        "log_decrement": 0.0123,
        "amplification_factor": None,
        "critically_damped": False,
        "excited_by": list(excited_by),
        "margin": margin,
        "margin_of": None if margin is None else excited_by[0],
    }


def lines_of_table(rows, width, operating=()):
    text = io.StringIO()
    console = Console(file=text, width=width, highlight=False)
    console.print(fitting_table(rows, console, operating))
    return [line.rstrip() for line in text.getvalue().splitlines() if line.strip()]


@pytest.mark.parametrize("width", [60, 80, 110])
def test_table_fits_its_width(width):
    """One line for each critical speed, nothing cut off, whatever has to be left out."""
    rows = [entry(11952.0, -0.004), entry(123456.0, 0.0), entry(21000.0, 0.25)]
    shown = lines_of_table(rows, width)
    assert max(len(line) for line in shown) <= width
    assert "…" not in "".join(shown)
    assert len(shown) == 2 + 1 + len(rows)  # head of two lines, a rule, the rows
    assert [line.split()[:2] for line in shown[-3:]] == [
        ["11952", "199.20"],
        ["123456", "2057.60"],
        ["21000", "350.00"],
    ]
    words = "0.4 % below lp", "inside the speeds of lp", "25 % above lp"
    short = "-0.4 % lp", "inside lp", "+25 % lp"
    for line, text in zip(shown[-3:], words if width > 80 else short, strict=True):
        assert line.endswith(text)


def test_a_column_that_says_the_same_everywhere_goes_first():
    rows = [entry(11952.0, -0.2, ("low_pressure_shaft",)) for _ in range(3)]
    head = " ".join(lines_of_table(rows, 80)[:2])
    assert "excited by" not in head
    assert "decr." in head
    other = [*rows, entry(9000.0, -0.2, ("high_pressure_shaft",))]
    head = " ".join(lines_of_table(other, 84)[:2])
    assert "excited by" in head
    assert "decr." not in head


def test_small_margins_are_told_with_a_digit():
    said = [
        long_margin({"margin": m, "margin_of": "hp"})
        for m in (-0.004, 0.0094, 0.0096, -0.0001, None)
    ]
    assert said == [
        *("0.4 % below hp", "0.9 % above hp", "1 % above hp"),
        *("< 0.1 % below hp", "-"),
    ]


def test_what_is_critically_damped_is_counted_not_listed():
    rows = [entry(1000.0 * k, None) | {"amplification_factor": 6.28} for k in range(1, 5)]
    rows[2] |= {"critically_damped": True, "amplification_factor": 0.2}
    shown = lines_of_table(rows, 110)
    assert "AF" in " ".join(shown[:2]) and all("6.28" in line for line in shown[3:6])
    assert not any(line.startswith(" 3000") for line in shown)
    assert shown[-1].strip() == "and 1 critically damped, see the report"
    assert lines_of_table(rows[2:3], 110) == [
        "no critical speed in the speed range; 1 critically damped"
    ]


def test_what_nothing_excites_is_counted_not_listed():
    rows = [entry(1000.0 * k, None) for k in range(1, 5)]
    rows[1] |= {"whirl": "torsional", "excited": False, "excited_by": []}
    shown = lines_of_table(rows, 110)
    assert not any("torsional" in line for line in shown)
    assert shown[-1].strip() == "and 1 not excited by unbalance, see the report"


def test_list_is_cut_by_the_rule_of_the_page():
    """Of twenty the twelve nearest to the operating speeds."""
    from solidwhirl.analyses.base import Operating

    rows = [entry(1000.0 * k, None) for k in range(1, 21)]
    lines = lines_of_table(rows, 110, (Operating("lp", 15500.0, 16500.0, 1.0),))
    shown = [line.split()[0] for line in lines if "backward" in line]
    assert shown == [f"{1000 * k}" for k in range(9, 21)]
    assert "and 8 more, see the report" in lines[-1]


def test_peaks_of_a_response_are_told_by_speed():
    from solidwhirl.analyses.unbalances import listed_peaks

    peaks = [{"speed_rpm": 9894.2, "frequency_hz": 164.9}]
    assert listed_peaks(peaks) == "9894 rpm (164.90 Hz)"
    assert listed_peaks([]) == "none"
