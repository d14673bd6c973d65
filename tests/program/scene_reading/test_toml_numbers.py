"""Other numbers in the text of a TOML file: only they change."""

from __future__ import annotations

import math
import re
import tomllib

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from solidwhirl.scene_reading.paths import with_entries
from solidwhirl.scene_reading.toml_numbers import with_numbers

SPACES = st.sampled_from(["", " ", "  ", "\t"])
COMMENTS = st.sampled_from(["", "  # 1e7 = [3]", ' # "quoted', "#", "  # ä ↔ 42"])
NUMBERS = st.sampled_from(["1e7", "+2", "-0.5", "1_000", "0", "3.0E-2", "0x1f", "1e10", "-7"])
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@st.composite
def texts(draw):
    """A text with comments, and the places of its numbers."""
    places, lines = [], []

    def number(*path):
        places.append(path)
        return draw(NUMBERS)

    def gap():
        return draw(SPACES)

    def end():
        return draw(COMMENTS) + draw(st.sampled_from(["\n", "\r\n"]))

    lines.append(f'name = "x = 3 # no comment"{end()}')
    lines.append(f"top{gap()}={gap()}{number('top')}{end()}")
    lines.append(f"a.b.c ={gap()}{number('a', 'b', 'c')}{end()}")
    for k in range(draw(st.integers(0, 3))):
        lines.append(f"[[bearings]]{end()}")
        values = [[number("bearings", k, "K", i, j) for j in range(2)] for i in range(2)]
        rows = [f"[{row[0]}{gap()},{gap()}{row[1]}{gap()}]" for row in values]
        lines.append(f"K = [{end()}{rows[0]},{end()} {rows[1]},{end()}]{end()}")
        lines.append(f'"a key" ={gap()}{number("bearings", k, "a key")}{end()}')
        x, z = (number("bearings", k, "t", *path) for path in (("x",), ("y", "z")))
        lines.append(f"t = {{ x = {x}, y.z = {z} }}{end()}")
        lines.append(f"text = '''1e7\n = 3'''{end()}")
    return "".join(lines), places


@settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(texts(), st.data())
def test_only_the_numbers_change(made, data):
    text, places = made
    chosen = data.draw(st.sets(st.sampled_from(places)))
    numbers = {path: data.draw(FINITE) for path in chosen}
    found = with_numbers(text, numbers)
    assert tomllib.loads(found) == with_entries(tomllib.loads(text), numbers)
    # all between numbers is there, byte for byte and in its order
    word = re.compile(r"(?<![\w.])[+-]?(?:0x\w+|\d[\d_]*(?:\.\d+)?(?:[eE][+-]?\d+)?)")
    assert word.split(found) == word.split(text)
    assert with_numbers(text, {}) == text


@pytest.mark.parametrize(
    ("before", "number", "after"),
    [
        ("1e10", 3.21e9, "3.21e9"),
        ("1e10", 25.0, "25.0"),
        ("20000", 19000.0, "19000"),
        ("20000", 19000.5, "19000.5"),
        ("0.5", 1e6, "1000000.0"),
        ("0x10", 3.0, "3.0"),
        ("1_000", -7.0, "-7"),
        ("1e-7", 2.5e-9, "2.5e-9"),
        ("8E6", math.pi * 1e6, "3141592.653589793"),
    ],
)
def test_numbers_are_written_as_those_before(before, number, after):
    assert with_numbers(f"x = {before} # it", {("x",): number}) == f"x = {after} # it"


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ('x = "3"', ("x",)),
        ("x = [1]", ("x",)),
        ("x = [1]", ("x", 1)),
        ("y = 1", ("x",)),
        ("[x]\ny = 1", ("x",)),
        ("x = true", ("x", 0)),
    ],
)
def test_places_without_a_number(text, path):
    with pytest.raises(ValueError, match="no number stands at"):
        with_numbers(text, {path: 1.0})


def test_a_text_that_is_no_toml_is_refused():
    with pytest.raises(ValueError):
        with_numbers("x = 1\ny = = 2", {("x",): 3.0})
