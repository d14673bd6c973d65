"""Refusals that are one message with exit code 2, and leave what others wrote alone."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from solidwhirl.cli import app
from solidwhirl.core.errors import markdown_cell, markdown_text
from solidwhirl.files.run_folder import claimed

TITLE = r"T <script>alert(1)</script> | **b** [x](y) $\unknown$ $1_$2"
NOTES = ("<img src=x> # not a heading | a", "# heading")
LONG = "x" * 300
DEEP = "/".join(["deep"] * 1000)


@pytest.fixture
def scene(rigid_scene, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return str(rigid_scene(TITLE, NOTES))


def refused(*words):
    done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exit_code == 2, done.output
    assert "Traceback" not in done.output
    assert done.exception is None or isinstance(done.exception, SystemExit)
    return " ".join(done.output.replace("│", " ").split())


FOLDERS = [
    ("run", "SCENE", "--out"),
    ("batch", "SCENE", "--out"),
    ("pictures", "SCENE", "--out"),
    ("study", "SCENE", "--out"),
    ("init",),
]
FILES = [
    ("geometry", "SCENE", "--step"),
    ("export", "SCENE", "--format", "npz", "-o"),
    ("check",),
    ("plan",),
    ("batch-pictures",),
    ("batch", "SCENE", "--out", "out", "--slurm"),
    ("run", "SCENE", "--out", "out", "--store"),
]


@pytest.mark.parametrize("words", FOLDERS + FILES)
def test_names_that_are_none_are_refused(scene, tmp_path, words):
    words = [scene if word == "SCENE" else word for word in words]
    for name in ("", LONG, f"a/{LONG}/b", DEEP):
        said = refused(*words, name)
        assert "is empty" in said or "too long" in said
    assert [path.name for path in tmp_path.iterdir()] == ["scene.toml"]


@pytest.mark.parametrize("words", FOLDERS)
def test_folders_in_a_file_are_refused(scene, tmp_path, words):
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    refused(*(scene if word == "SCENE" else word for word in words), tmp_path / "file" / "out")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


@pytest.mark.solver
def test_own_results_are_not_replaced(scene, tmp_path):
    (tmp_path / "results.json").write_text("mine", encoding="utf-8")
    said = refused("run", scene, "--out", ".", "--no-pictures")
    assert "is not empty (results.json, scene.toml) and no run wrote it" in said
    (tmp_path / ".stages").mkdir()  # as in the folder of a run
    said = refused("run", scene, "--out", ".", "--no-pictures")
    assert "results.json: is there already and no run wrote it" in said
    assert (tmp_path / "results.json").read_text(encoding="utf-8") == "mine"
    (tmp_path / "batch.jsonl").write_text("mine\n", encoding="utf-8")
    assert "no batch wrote it" in refused("batch", scene, "--out", ".", "--no-pictures")
    assert (tmp_path / "batch.jsonl").read_text(encoding="utf-8") == "mine\n"


@pytest.mark.solver
def test_folder_of_a_case_that_runs_is_refused(scene, tmp_path):
    with claimed(tmp_path / "batch" / "rotor"):
        assert "is not empty (rotor)" in refused("batch", scene, "--out", tmp_path / "batch")
    with claimed(tmp_path / "batch"):
        out = tmp_path / "batch" / "rotor"
        assert "is writing the folder" in refused("run", scene, "--out", out)
        said = refused("batch", scene, "--out", tmp_path / "batch", "--resume")
        assert "batch: another run is writing here" in said
    assert not (tmp_path / "batch").exists()  # made for the first, which left nothing in it


@pytest.mark.solver
def test_texts_of_a_scene_are_no_markup(scene, tmp_path):
    """Neither in pictures, which would fail on such formulas, nor in reports."""
    done = CliRunner().invoke(app, ["run", scene, "--out", str(tmp_path / "out"), "-q"])
    assert done.exit_code == 0, done.output
    report = (tmp_path / "out" / "report.md").read_text("utf-8")
    assert "<script>" not in report and "<img" not in report
    assert report.splitlines()[0].startswith(r"# T &lt;script&gt;alert(1)&lt;/script&gt; \| \*\*b")
    assert r"- \# heading" in report.splitlines()


def test_markdown_is_escaped_and_plain_text_is_not():
    assert markdown_text("a_b at 5 % of 3 mm, -1 is_x") == "a_b at 5 % of 3 mm, -1 is_x"
    assert markdown_text("_x_ `y`\n2. z") == r"\_x\_ \`y\` 2. z"
    assert markdown_text("1. a") == r"1\. a"
    assert markdown_text("[a]: b [c](d) &lt;") == r"\[a]: b [c\](d) &amp;lt;"
    for begins in ("#", "-", "- a", "+ a", "---", "===", "> a"):
        assert markdown_text(begins)[0] in "\\&"
    for plain in ("9850.4", "-1.2e-02", "analyses[1].to_rpm: <= 3 or > 5 & a -> b"):
        assert markdown_text(plain) == markdown_cell(plain) == plain
    assert markdown_cell("-") == "-"


@pytest.mark.solver
def test_quiet_batch_names_what_failed(scene, tmp_path):
    bad = tmp_path / "bad.toml"
    text = Path(scene).read_text("utf-8").replace("mass_kg = 10.0", "mass_kg = 1e-29")
    bad.write_text(text.replace('"rotor"', '"bad"', 1), encoding="utf-8")
    done = CliRunner().invoke(
        app, ["batch", scene, str(bad), "--out", str(tmp_path / "b"), "--no-pictures", "-q"]
    )
    assert done.exit_code == 1
    (line,) = [line for line in done.stderr.splitlines() if "FAILED" in line]
    assert line.startswith("bad FAILED in")
    # a line that is damaged costs its own case alone
    journal = tmp_path / "b" / "batch.jsonl"
    lines = journal.read_text("utf-8").splitlines(keepends=True)
    kept = next(line for line in lines if json.loads(line)["case"] == "rotor")
    journal.write_text("{damaged\n" + kept, encoding="utf-8")
    done = CliRunner().invoke(
        app, ["batch", scene, "--out", str(tmp_path / "b"), "--no-pictures", "--resume"]
    )
    assert done.exit_code == 0, done.output
    assert "line 1: is damaged" in done.stderr
    assert "0 cases to compute, 1 kept" in done.stderr


@pytest.mark.solver
def test_exports_replace_files_when_told(scene, tmp_path):
    assert CliRunner().invoke(app, ["run", scene, "--out", "o", "--no-pictures"]).exit_code == 0
    body = tmp_path / "o" / "bodies" / "rotor.h5"
    for kind in ("npz", "dmig"):
        out = tmp_path / f"x.{kind}"
        words = ["export", str(body), "--format", kind, "-o", str(out)]
        assert CliRunner().invoke(app, words).exit_code == 0
        written = set(tmp_path.glob("x.*"))
        for path in written:
            path.write_text("mine", encoding="utf-8")
        assert "is there already; --force replaces it" in refused(*words)
        assert {path.read_text("utf-8") for path in written} == {"mine"}
        assert CliRunner().invoke(app, [*words, "--force"]).exit_code == 0
        assert out.read_bytes() != b"mine"
        for path in written:
            path.unlink()
    assert not list(tmp_path.glob(".writing-*"))


@pytest.mark.parametrize("speeds", [(0, 0, 2), (500, 500, 3), (1e6, 1e6 + 1e-9, 100)])
def test_speeds_that_are_one_are_named_by_their_keys(scene, tmp_path, speeds):
    first, last, count = speeds
    text = Path(scene).read_text("utf-8").replace("from_rpm = 0", f"from_rpm = {first!r}")
    text = text.replace("to_rpm = 3000", f"to_rpm = {last!r}")
    (tmp_path / "scene.toml").write_text(text.replace("count = 3", f"count = {count}"), "utf-8")
    said = refused("plan", scene)
    assert f"speeds: count = {count} speeds" in said and "allowed is count = 1" in said
