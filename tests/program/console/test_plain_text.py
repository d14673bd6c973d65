"""Tables of a terminal."""

from __future__ import annotations

from solidwhirl.console.plain_text import plain_text
from solidwhirl.core.blocks import Table

TABLE = Table(
    head=("effect", "why"),
    rows=[("gyroscopic", "bodies turn about their axes"), ("tilt", "none \x1b[31m")],
)


def test_a_table_is_as_wide_as_it_needs():
    assert plain_text([TABLE], 200).splitlines()[2:] == [
        " gyroscopic  bodies turn about their axes",
        " tilt        none \\x1b[31m",
    ]


def test_words_are_parted_where_nothing_else_fits():
    narrow = plain_text(["Warnings:", ["mass of 1e9 kg is far too much"], TABLE], 26).splitlines()
    assert max(map(len, narrow)) <= 26
    assert "- mass of 1e9 kg is far" in narrow and "  too much" in narrow
    assert " gyroscopic  bodies turn" in narrow
    assert max(map(len, plain_text([TABLE], 12).splitlines())) <= 12
