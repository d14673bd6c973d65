"""The tool that writes the page of the paper: no results typed, and its own closed forms."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from paper import twin_rotor, units, variants  # noqa: E402
from paper.rows import per_cent  # noqa: E402
from paper.runs import SOURCE  # noqa: E402

# Write scene files, of which all numbers are input.
NO_PAGE = {"compose.py", "compose_bladed.py"}
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.]*\.(?:png|md|json|toml))")
YEAR = re.compile(r"\((?:19|20)\d\d\)")


def constants(tree: ast.Module) -> Iterator[tuple[int, object]]:
    """Constants of a module with their lines, docstrings left out."""
    owners = (ast.Module, ast.ClassDef, ast.FunctionDef)
    said = {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, owners) and node.body and isinstance(node.body[0], ast.Expr)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and id(node) not in said:
            yield node.lineno, node.value


def is_precise(text: str) -> bool:
    """Whether a number has three significant digits or more, as a result has."""
    digits = text.lower().partition("e")[0].replace(".", "").strip("0")
    return len(digits) > 2


def literals(source: str) -> list[tuple[int, str]]:
    """Numbers of a module that look like results."""
    found = []
    for line, value in constants(ast.parse(source)):
        if isinstance(value, str):
            texts = NUMBER.findall(YEAR.sub("", value))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            texts = [repr(value)]
        else:
            texts = []
        found += [(line, text) for text in texts if is_precise(text)]
    return found


def test_no_result_is_typed():
    assert literals('x = 0.315\ny = f"{x} at 153.22 Hz and 9000 rpm"') == [
        (1, "0.315"),
        (2, "153.22"),
    ]
    for path in sorted((ROOT / "tools" / "paper").glob("*.py")):
        if path.name not in NO_PAGE:
            assert not literals(path.read_text(encoding="utf-8")), path.name


def test_one_term_model_is_what_the_source_calls_analytic():
    model = twin_rotor.one_term()
    printed = SOURCE["table_2"]["analytic"], SOURCE["table_3"]["analytic"]
    np.testing.assert_allclose(model.frequencies(0.0), printed[0], rtol=1e-4)
    np.testing.assert_allclose(model.peaks(), printed[1], rtol=2e-3)
    # the dynamic stiffness is singular at its frequencies, and at its peaks
    speed = 700.0
    for hertz in model.frequencies(speed):
        values = np.linalg.svd(model.dynamic(speed, 2 * np.pi * hertz), compute_uv=False)
        assert values[1] < 1e-9 * values[0]
    for hertz in model.peaks():
        omega = 2 * np.pi * hertz
        values = np.linalg.svd(model.dynamic(omega, omega), compute_uv=False)
        assert values[1] < 1e-9 * values[0]
    # slowly it is a spring: the longer axis of the orbit is along the softer one
    slow = 1e-3
    expected = 1e-7 * slow**2 * model.disk**2 / min(model.stiffness_n_per_m)
    assert model.amplitude(slow, 1e-7) == pytest.approx(expected, rel=1e-6)


def test_bearing_polynomials_are_solved_for_the_printed_ratio():
    rows = units._table_5_over_speed()
    for row, unit in zip(rows, units.DESIGN, strict=True):
        at_rest, at_design, _ = SOURCE["table_5"][unit]
        speed = units.speed_of_ratio(at_design / at_rest)
        assert units.KXX(speed) == pytest.approx(at_design / at_rest, rel=1e-9)
        assert row.ours.startswith(f"{speed:.5g}")


def test_rows_have_an_error_bar():
    row = per_cent("f", "w", 100.0, 101.0, "Hz", "identified", 2e-3)
    assert (row.ours, row.difference, row.error) == ("101 ± 0.2 Hz", 1.0, 0.2)


def test_circles_are_seen_at_the_frequency_of_the_frame():
    """A hub on equal springs resonates at f in fixed axes; the rotor sees f - spin and f + spin."""
    hertz = np.arange(1.0, 201.0)
    seen = units.seen_frequencies(np.array([80.0, 80.0]), 100.0)
    np.testing.assert_allclose(seen, [[20.0, 20.0], [180.0, 180.0]])
    heights = units.in_steps(hertz, seen, np.array([[3.0, 2.0], [1.0, 0.5]]))
    assert heights[19] == 3.0 and heights[179] == 1.0 and np.count_nonzero(heights) == 2


def test_units_are_brought_back_to_their_targets_within_the_bounds():
    """Two targets of three parameters, with slopes that are wrong by a third."""

    def missed(point: np.ndarray) -> np.ndarray:
        return 1e3 * np.array([point[0] * point[1] - 0.25, point[1] + point[2] ** 2 - 0.6])

    wrong = 1e3 * np.array([[0.6, 0.3, 0.0], [0.0, 0.7, 1.2]])
    found = variants._brought_back(missed, np.array([0.9, 0.4, 0.6]), wrong, near=0.1)
    assert found is not None and np.abs(missed(found)).max() < 0.1
    assert found.min() >= 0.0 and found.max() <= 1.0
    impossible = variants._brought_back(lambda u: missed(u) + 1e4, found, wrong)
    assert impossible is None
