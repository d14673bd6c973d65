"""Messages about a scene file point at the line and column they are about."""

from __future__ import annotations

import random
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from solidwhirl.core.errors import SceneError
from solidwhirl.scene_reading.lines import line_of, with_lines
from solidwhirl.scene_reading.reader import read_scene
from solidwhirl.scene_reading.toml_places import Places

FOLDER = Path(__file__).resolve().parents[3] / "scenes"
SCENES = sorted(FOLDER.glob("**/*.toml"))
ADDED = "zz"


def paths(value, path=()):
    """Paths of everything in a document."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, inner in items:
        yield (*path, key)
        if isinstance(inner, dict | list):
            yield from paths(inner, (*path, key))


def at(data, path):
    for part in path:
        data = data[part]
    return data


def index_of(text, place):
    """Index of a line and column, counted without the program's help."""
    lines = text.split("\n")
    return sum(len(line) + 1 for line in lines[: place.line - 1]) + place.column - 1


def renamed(text, place):
    """The text with its key at a place called otherwise."""
    index = index_of(text, place)
    index += text[index] in "\"'"  # into the quotes
    return text[:index] + ADDED + text[index:]


@pytest.mark.parametrize("scene", SCENES, ids=lambda p: p.stem)
def test_every_key_of_a_scene_has_a_place(scene):
    """Where a place says a key stands, another name changes that key and nothing else.

    The judge is Python's own TOML parser.
    """
    text = scene.read_text(encoding="utf-8")
    data = tomllib.loads(text)
    places = Places(text)
    own = [path for path in paths(data) if isinstance(path[-1], str)]
    assert all(places.position(path) for path in paths(data))
    # keys of tables whose name stands in more headers than one can not be renamed by one change
    leaves = [path for path in own if not isinstance(at(data, path), dict | list)]
    for path in random.Random(1).sample(leaves, min(12, len(leaves))):
        changed = tomllib.loads(renamed(text, places.position(path)))
        holder = at(changed, path[:-1])
        assert holder.pop(ADDED + path[-1]) == at(data, path)
        expected = dict(at(data, path[:-1]))
        del expected[path[-1]]
        assert holder == expected


def test_elements_of_lists_stand_where_their_values_begin():
    text = 'a = [1, [ 22,\n 333 ], "x # y", { k = 4 }]\n[[b]]\n\n[[b]]\n  c.d = [5]\n'
    places = Places(text)
    begins = {
        ("a", 0): "1",
        ("a", 1): "[ 22",
        ("a", 1, 1): "333",
        ("a", 2): '"x #',
        ("a", 3): "{ k",
        ("a", 3, "k"): "k = 4",
        ("b", 0): "[[b]]\n\n",
        ("b", 1): "[[b]]\n  c",
        ("b", 1, "c", "d"): "d = [",
        ("b", 1, "c", "d", 0): "5",
    }
    for path, begin in begins.items():
        assert text[index_of(text, places.position(path)) :].startswith(begin), path
    assert places.position(("a", 4)) is None
    assert places.position(()) is None


KEYS = st.one_of(
    st.from_regex(r"[A-Za-z0-9_-]{1,6}", fullmatch=True),
    st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs")), max_size=5),
)
ODD = (
    '"a = 1 # no"',
    "'[[x]]'",
    '"""\n"quoted"\nb = 2\n"""',
    "'''\n''x''\n'''",
    "1979-05-27 07:32:00",
    "-1.5e3",
    "true",
    '"\\"]"',
)
VALUES = st.recursive(
    st.sampled_from(ODD),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(KEYS, inner, max_size=3)),
    max_leaves=6,
)
GAPS = st.sampled_from(["", " ", "  "])
LINES = st.sampled_from(["", "# [t]\n", "\n", "  # a = 1\n\t\n"])


class Writer:
    """Writes a document as TOML and notes where everything begins."""

    def __init__(self, draw):
        self.draw, self.text, self.places = draw, "", {}

    def key(self, name):
        bare = re.fullmatch(r"[A-Za-z0-9_-]+", name)
        escaped = name.replace("\\", "\\\\").replace('"', '\\"')
        self.text += name if bare else f'"{escaped}"'

    def value(self, value, path):
        if isinstance(value, str):
            self.text += value
            return
        is_table = isinstance(value, dict)
        self.text += "{" if is_table else "["
        for k, (key, inner) in enumerate(value.items() if is_table else enumerate(value)):
            gap = "" if is_table else "\n " * self.draw(st.integers(0, 1))
            self.text += (", " if k else "") + gap + self.draw(GAPS)
            self.places[(*path, key)] = len(self.text)
            if is_table:
                self.key(key)
                self.text += self.draw(GAPS) + "="
                self.text += self.draw(GAPS)
            self.value(inner, (*path, key))
        self.text += self.draw(GAPS) + ("}" if is_table else "]")

    def table(self, table, path):
        for key, value in table.items():
            self.text += self.draw(LINES) + self.draw(GAPS)
            self.places[(*path, key)] = len(self.text)
            self.key(key)
            self.text += " = "
            self.value(value, (*path, key))
            self.text += self.draw(st.sampled_from(["\n", " # b = 3\n"]))


TABLES = st.dictionaries(KEYS, VALUES, max_size=3)


@st.composite
def documents(draw):
    """A text, and the index where each key and element begins."""
    writer = Writer(draw)
    top = draw(TABLES)
    writer.table(top, ())
    names = draw(st.lists(KEYS.filter(lambda k: k not in top), max_size=3, unique=True))
    for name in names:
        elements = draw(st.one_of(st.none(), st.lists(TABLES, min_size=1, max_size=3)))
        for k, table in enumerate([draw(TABLES)] if elements is None else elements):
            writer.text += draw(LINES)
            path = (name,) if elements is None else (name, k)
            writer.places[path] = len(writer.text)
            writer.places.setdefault((name,), len(writer.text))
            writer.text += "[" if elements is None else "[["
            writer.key(name)
            writer.text += "]\n" if elements is None else "]]\n"
            writer.table(table, path)
    return writer.text, writer.places


@settings(max_examples=20, deadline=None)
@given(documents())
def test_places_are_those_of_the_writer(found):
    text, written = found
    assert set(paths(tomllib.loads(text))) == set(written)  # the writer writes TOML
    places = Places(text)
    told = {path: index_of(text, places.position(path)) for path in written}
    assert told == written


LAVAL = (FOLDER / "laval.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "is_comma"),
    [
        ("to_rpm = 6000", "to_rpm = 0,14", True),
        ("to_rpm = 6000", "to_rpm = -0,14e3  # x", True),
        ("end_m = 1.0,", "end_m = 1,0,", True),
        ("mass_kg = 5.0,", "mass_kg = 5,14e-1 ,", True),
        ("to_rpm = 6000", "to_rpm = 6000, 5", False),
        ("to_rpm = 6000", "to_rpm = [0,14 3]", False),
        ("to_rpm = 6000", "to_rpm = [0,14;", False),
        ("to_rpm = 6000", "to_rpm = 6000 count", False),
        ("end_m = 1.0,", "end_m 1.0,", False),
        ("end_m = 1.0,", "end_m = 1.0,, ", False),
    ],
)
def test_syntax_is_said_with_one_place(tmp_path, changed, old, new, is_comma):
    """And a decimal comma with a hint, where the text there is one."""
    path = tmp_path / "s.toml"
    path.write_text(changed(LAVAL, old, new), encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        read_scene(path)
    message = str(caught.value)
    place = re.search(r"\(at line (\d+), column (\d+)\)", str(caught.value.__cause__))
    # a missing comma is one behind the value before
    column = int(place[2]) - ("[0,14 3]" in new)
    assert message.startswith(f"{path}:{place[1]}:{column}: is not valid TOML: ")
    assert str(with_lines(caught.value)) == message
    assert "(at" not in message
    assert message.endswith("a decimal point is wanted, not a comma") == is_comma


def test_what_has_no_place_stays_as_it_is(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text("a = 1\n", encoding="utf-8")
    for message in ("b: unknown", "a lot is wrong", "scene: needs a body", "nothing"):
        assert line_of(path, message) == f"{path}: {message}"
    assert line_of(path, "a.b[3]: missing") == f"{path}:1:1: a.b[3]: missing"
    for other in (tmp_path, tmp_path / "none.toml", Path("/dev/zero"), Path("a\0b")):
        assert line_of(other, "a: wrong") == f"{other}: a: wrong"
    long = SceneError(path, ["a: wrong " + "x" * 300] * 90)
    assert len(str(with_lines(long))) < 3200
    assert str(with_lines(long)).splitlines()[-1].endswith("more like these")
