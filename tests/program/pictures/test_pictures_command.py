"""The command draws what is asked for, once, and says what it can not draw."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from solidwhirl.commands.pictures import chosen_formats, chosen_pictures, pictures_command
from solidwhirl.core.errors import OutputError
from solidwhirl.files.picture_index import Picture
from solidwhirl.pictures import catalogue
from solidwhirl.pictures.catalogue import pictures_of
from solidwhirl.pictures.picture_names import refuse_unknown_names
from solidwhirl.pipeline import run as pipeline
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import read_scene

SCENES = Path(__file__).parents[3] / "scenes"


@pytest.mark.parametrize(
    ("text", "expected"),
    [("pdf", ("pdf",)), (" PDF, svg,pdf", ("pdf", "svg")), ("gif,mp4", ("gif", "mp4"))],
)
def test_formats(text, expected):
    assert chosen_formats(text) == expected
    allowed = "allowed are pdf, svg, png, gif, mp4"
    for wrong, message in (
        ("jpg", f"unknown 'jpg'; did you mean 'png'\\? {allowed}"), (",", f"no format; {allowed}"),
    ):  # fmt: skip
        with pytest.raises(OutputError, match=message):
            chosen_formats(wrong)


def test_names_are_different_and_can_be_chosen(laval):
    pictures = pictures_of(laval, modes=2)
    names = [p.name for p in pictures]
    assert len(set(names)) == len(names)
    assert {"engine", "campbell", "mode_critical_1", "mode_critical_1_film"} <= set(names)
    # notes and damping have diagrams of their own
    plain = laval.campbell
    noted = replace(plain, log_decrement=plain.log_decrement + 0.1, notes=("a note",))
    more = {p.name for p in pictures_of(replace(laval, campbell=noted), modes=2)}
    assert more - set(names) == {"campbell_annotated", "campbell_damped"}
    assert [p.name for p in chosen_pictures(pictures, ["camp*"])] == ["campbell"]
    assert chosen_pictures(pictures, []) == pictures
    said = r"no picture 'engin'; did you mean 'engine'\? allowed are engine, campbell, "
    with pytest.raises(OutputError, match=said):
        chosen_pictures(pictures, ["engin"])


def test_pictures_are_written_with_a_page(laval, tmp_path):
    lines = []
    done = pictures_command(
        laval.scene, tmp_path / "out", lines.append, formats="svg,pdf", only=["engine", "campbell"]
    )
    assert [f.name for f in done.files] == [
        "engine.svg", "engine.pdf", "campbell.svg", "campbell.pdf",
    ]  # fmt: skip
    assert done.failed == ()
    assert done.files[0].read_bytes().startswith(b"<?xml")
    assert done.files[1].read_bytes().startswith(b"%PDF")
    text = done.index.read_text(encoding="utf-8")
    assert all(f"({f.name})" in text for f in done.files)
    assert "draw engine.svg" in lines
    assert not list(tmp_path.glob("out/.lock"))


def test_second_time_nothing_is_drawn_again(laval, tmp_path, monkeypatch):
    ask = {"formats": "svg", "only": ["engine"]}
    first = pictures_command(laval.scene, tmp_path, lambda text: None, **ask)
    before = first.files[0].read_bytes()

    def refuse(*arguments):
        raise AssertionError("drawn again")

    monkeypatch.setattr(catalogue, "draw_engine", refuse)
    stages = {f.name for f in tmp_path.glob(".stages/*")}
    lines = []
    second = pictures_command(laval.scene, tmp_path, lines.append, **ask)
    assert second.files[0].read_bytes() == before
    assert len(stages) > 2 and {f.name for f in tmp_path.glob(".stages/*")} == stages
    with pytest.raises(AssertionError, match="drawn again"):  # another format is another picture
        pictures_command(laval.scene, tmp_path, lines.append, formats="pdf", only=["engine"])


def test_what_can_not_be_drawn_does_not_stop_the_others(laval, tmp_path, monkeypatch):
    def broken(scene, silhouettes, path, title):
        raise ValueError("no ink")

    monkeypatch.setattr(catalogue, "draw_engine", broken)
    done = pictures_command(
        laval.scene, tmp_path, lambda text: None, formats="svg", only=["engine", "campbell"]
    )
    assert done.failed == (("engine.svg", "no ink"),)
    assert [f.name for f in done.files] == ["campbell.svg"]
    assert not (tmp_path / "engine.svg").exists()


def test_a_later_call_adds_to_the_list(laval, tmp_path):
    """Earlier pictures stay in it while their files are there, in the order of the catalogue."""

    def listed():
        text = (tmp_path / "pictures.md").read_text(encoding="utf-8")
        return re.findall(r"\]\(([^)]*)\)", text)

    def draw(formats, name):
        pictures_command(laval.scene, tmp_path, lambda t: None, formats=formats, only=[name])

    draw("svg", "campbell")
    draw("svg", "engine")
    assert listed() == ["engine.svg", "campbell.svg"]
    draw("pdf", "campbell")
    assert listed() == ["engine.svg", "campbell.pdf", "campbell.svg"]
    (tmp_path / "engine.svg").unlink()
    draw("pdf", "campbell")
    assert listed() == ["campbell.pdf", "campbell.svg"]
    text = (tmp_path / "pictures.md").read_text(encoding="utf-8")
    assert text.count("Natural frequencies over the speed") == 1


@pytest.mark.parametrize("name", ["engin", "mesh_x", "mode_critical_9", "camp*x", "mode_1_movie"])
def test_an_unknown_name_is_refused_before_anything_is_computed(laval, tmp_path, monkeypatch, name):
    def refuse(*arguments, **options):
        raise AssertionError("computed")

    monkeypatch.setattr(pipeline, "run_scene", refuse)
    with pytest.raises(OutputError, match=r"no picture '.*there may be engine, "):
        pictures_command(laval.scene, tmp_path / "out", lambda t: None, only=[name])
    with pytest.raises(OutputError, match="none of png is a format of mode_1_film"):
        pictures_command(laval.scene, tmp_path / "out", lambda t: None, only=["mode_1_film"])
    assert Picture(name="a", kind="film", caption="", draw=print).formats == ("gif", "mp4")
    assert not (tmp_path / "out").exists()


def test_no_name_of_a_run_is_refused_early(laval, twin, geared):
    """What the catalogue has may be asked for, by name and by patterns."""
    response, *_ = read_scene(SCENES / "ferraris.toml").analyses
    analyses = (response.model_copy(update={"count": 21}),)
    twice = run_scene(twin.scene.model_copy(update={"analyses": analyses}))
    for run in (laval, twin, geared, twice):
        for picture in pictures_of(run, modes=3):
            name = picture.name
            refuse_unknown_names(run.scene, [name, f"{name[:3]}*", f"?{name[1:]}", "*"], 3)
    labels = [spec.label for spec in twice.scene.analyses]
    assert any(p.name.startswith(labels[0]) for p in pictures_of(twice))
    with pytest.raises(OutputError, match=r"unbalance_response\.\.\."):
        refuse_unknown_names(twice.scene, ["unbalance_respond"], 3)
