"""The documentation says what is so: its code runs, its commands, files and links exist."""

from __future__ import annotations

import importlib
import multiprocessing
import os
import re
import shlex
import subprocess
import sys
import tomllib
import unicodedata
from pathlib import Path

import h5py
import pytest
from pages import FENCE, PAGES, ROOT, blocks, name_of

from solidwhirl.cost.forecast import forecast
from solidwhirl.model.bodies import build_bodies
from solidwhirl.model.effects import make_plan
from solidwhirl.model.mesh_bodies import build_mesh_bodies
from solidwhirl.rotordyn import beam_superelement, write_superelement
from solidwhirl.scene_reading.reader import parse_scene

FLAGS = re.DOTALL | re.MULTILINE
# words before the name of a file that a command writes
WRITING = ("--out", "init", ">")
# [text](target) and ![text](target)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def blocks_of(page, language):
    """(mark, text) of the blocks of a language."""
    return [(mark, text) for mark, kind, text in blocks(page) if kind == language]


def rest_after(page, text):
    """What follows a block; a text block there is what it prints."""
    return page.read_text(encoding="utf-8").split(text, 1)[1]


def commands(page):
    """Lines of the sh blocks, without comments."""
    lines = [line for _, text in blocks_of(page, "sh") for line in text.splitlines()]
    return [words for line in lines if (words := shlex.split(line, comments=True))]


def scene_texts(page):
    """TOML blocks; one that begins with `# <file>, continued` belongs to the one before."""
    texts = []
    for _, text in blocks_of(page, "toml"):
        if texts and text.split("\n")[0].endswith(".toml, continued"):
            texts.append(texts[-1] + text)
        else:
            texts.append(text)
    return texts


MARKED = {
    page: [(mark, text) for mark, text in blocks_of(page, "python") if mark.startswith("test")]
    for page in PAGES
}
WITH_CODE = [
    pytest.param(page, mark, id=f"{name_of(page)}-{mark}", marks=[pytest.mark.solver] * solver)
    for page, found in MARKED.items()
    for mark, solver in (("test", 0), ("test: solver", 1))
    if any(m == mark for m, _ in found)
]


def test_every_python_block_is_marked():
    for page in PAGES:
        assert len(MARKED[page]) == len(blocks_of(page, "python")), name_of(page)
    assert {name_of(p.values[0]) for p in WITH_CODE} >= {"README.md", "docs/superelement.md"}


# Processes that have imported the most already.
PROCESSES = multiprocessing.get_context("forkserver")
PROCESSES.set_forkserver_preload(["solidwhirl.rotordyn"])


def execute(text, folder):
    """Run a block, which prints into files of a folder."""
    os.chdir(folder)
    sys.path.insert(0, str(folder))
    for stream, name in ((1, "stdout"), (2, "stderr")):
        os.dup2(os.open(name, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), stream)
    exec(compile(text, "block", "exec"), {"__name__": "__main__"})


def run_block(text, folder):
    """What a block prints in a process of its own, and what it says beside that."""
    process = PROCESSES.Process(target=execute, args=(text, folder))
    process.start()
    process.join(120)
    printed, said = ((folder / name).read_text("utf-8") for name in ("stdout", "stderr"))
    assert process.exitcode == 0, f"{text}\n{said}"
    return printed, said


@pytest.mark.parametrize(("page", "mark"), WITH_CODE)
def test_python_blocks_run(page, mark, tmp_path):
    """Each in a process of its own, as a reader would; blocks of a page share a folder.

    One that begins with `# <file>.py` is also that file.
    """
    (tmp_path / "scenes").symlink_to(ROOT / "scenes", target_is_directory=True)
    for number, (own, text) in enumerate(MARKED[page]):
        if own != mark:
            continue
        if named := re.match(r"# (\w+\.py)\n", text):
            (tmp_path / named[1]).write_text(text, encoding="utf-8")
        printed, said = run_block(text, tmp_path)
        assert "Warning" not in said, said
        shown = re.match(r"```\n\n```text\n(.*?)^```$", rest_after(page, text), FLAGS)
        assert shown is None or shown[1] == printed, f"{name_of(page)}, block {number}"


def test_reader_of_the_superelement_page_agrees_with_the_program(tmp_path):
    import numpy as np

    from solidwhirl.rotordyn import Bearing, End, Rotor, assemble, modes_at_speed, read_superelement

    page = ROOT / "docs" / "superelement.md"
    for _, text in MARKED[page]:
        printed, _ = run_block(text, tmp_path)
    springs = tuple(
        Bearing(name=n, first=End(body="r", interface=n), stiffness_n_per_m=5e7 * np.eye(2))
        for n in ("a", "b")
    )
    rotor = Rotor(element=read_superelement(tmp_path / "shaft.h5"), speed_ratio=1.0)
    expected = modes_at_speed(assemble({"r": rotor}, springs), 1000.0, 4).frequency_hz
    found = [float(word) for word in re.findall(r"[\d.]+", printed)]
    # printed to two decimals
    np.testing.assert_allclose(found, expected, atol=0.0051, rtol=0)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_command_lines_are_valid(page):
    """Parsed by the command line itself, not run."""
    from solidwhirl.cli import every_command

    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    told = "\n".join(text for _, text in blocks_of(page, "toml"))
    written: set[str] = set()
    for words in commands(page):
        if words[0] == "make":
            named = [w for w in words[1:] if "=" not in w]
            assert named and set(named) <= set(targets), words
            for scene in (w.removeprefix("SCENE=") for w in words if w.startswith("SCENE=")):
                assert (ROOT / "scenes" / f"{scene}.toml").is_file(), words
            continue
        at = [k for k, w in enumerate(words) if Path(w).name == "solidwhirl"]
        if at:
            name, *arguments = words[at[0] + 1 :]
            # an unknown option or a missing argument raises
            every_command()[name].make_context(name, arguments)
        # what follows --out, init and > is written, not read
        read = [w for k, w in enumerate(words) if k == 0 or words[k - 1] not in WRITING]
        written |= set(words) - set(read)
        for path in (w for w in read if w.endswith((".toml", ".py"))):
            known = (ROOT / path).is_file() or f"# {path}\n" in told or path in written
            assert known, words


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_links_lead_somewhere(page):
    # code may hold brackets that are no links
    prose = re.sub(r"`[^`\n]*`", "", FENCE.sub("", page.read_text(encoding="utf-8")))
    for target in LINK.findall(prose):
        if re.match(r"[a-z]+://|mailto:", target):
            continue
        path, _, anchor = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        assert file.exists(), f"{name_of(page)}: {target}"
        assert file.is_relative_to(ROOT), f"{name_of(page)}: {target}"
        if anchor:
            assert anchor in anchors(file), f"{name_of(page)}: {target}"


def anchors(page):
    """Anchors of the headings, made as Git hosts make them."""
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    found = set()
    for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE):
        kept = [
            c for c in heading.lower() if c in "-_ " or unicodedata.category(c)[0] in ("L", "N")
        ]
        found.add("".join(kept).replace(" ", "-"))
    return found


@pytest.mark.parametrize("page", [p for p in PAGES if blocks_of(p, "toml")], ids=name_of)
def test_toml_blocks_are_scenes(page):
    """Each is planned, with all that a run forecasts before its long work."""
    for text in scene_texts(page):
        scene = parse_scene(tomllib.loads(text), name_of(page))
        bodies = build_bodies(scene)
        plan = make_plan(scene, bodies)
        assert forecast(scene, plan, {**bodies, **build_mesh_bodies(scene)}).seconds > 0.0


def test_superelement_page_names_every_part_of_a_file(tmp_path):
    text = (ROOT / "docs" / "superelement.md").read_text(encoding="utf-8")
    shaft = beam_superelement("s", [0.0, 0.5], 0.02, 0.0, (2e11, 0.3, 7800.0), {"a": 0.0})
    write_superelement(shaft, tmp_path / "s.h5")
    datasets, attributes = set(), set()
    with h5py.File(tmp_path / "s.h5") as file:
        file.visititems(lambda name, node: datasets.add(name) if is_dataset(node) else None)
        attributes |= set(file.attrs) | set(file["operators/M"].attrs)
    # json of the provenance is an attribute in a short file
    listed = set(re.findall(r"^\| `(\w+/\w+)` \|", text, re.MULTILINE))
    # error forms have a table of their own: their parts differ by body
    assert listed == {name for name in datasets if not name.startswith("error_forms/")}
    assert not [name for name in sorted(attributes) if f"`{name}`" not in text]


def is_dataset(node):
    return isinstance(node, h5py.Dataset)


def test_pages_speak_of_the_project_alone():
    for page in PAGES:
        assert not re.search(r"(?<![\w.])/(work|tmp|root)\b", page.read_text(encoding="utf-8"))


def test_page_of_all_keys_is_what_the_records_say():
    done = subprocess.run(
        [sys.executable, "tools/scene_reference.py", "--check"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr


def test_every_analysis_has_a_how_to():
    from solidwhirl.analyses.registry import KINDS

    kinds = set(KINDS)
    assert len(kinds) > 10
    text = "".join(text for _, text in blocks_of("docs/howto.md", "toml"))
    assert kinds <= set(re.findall(r'kind = "(\w+)"', text))


# `reduction.operators.forms`, with or without a name in it
STAGE = "geometry|meshing|reduction|rotordyn"
MODULE = re.compile(rf"`((?:solidwhirl\.)?(?:{STAGE})\.[A-Za-z_.]*[a-z])")


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_modules_that_pages_name_exist(page):
    for name in set(MODULE.findall(page.read_text(encoding="utf-8"))):
        found, *rest = name.removeprefix("solidwhirl.").split(".")
        stage, folder = importlib.import_module(f"solidwhirl.{found}"), ROOT / found
        while rest and (folder / rest[0]).is_dir():
            folder /= rest.pop(0)
        module = rest and (folder / f"{rest[0]}.py").exists()
        assert not rest or module or hasattr(stage, rest[0]), f"{name_of(page)}: no {name}"


def test_where_is_it_leads_to_files():
    """Eleven questions, each answered by a walk of folder names to files that are there."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.+\?) \| (.+) \|$", text, re.MULTILINE)
    assert len(rows) == 11
    for question, walks in rows:
        for walk in walks.split(";"):
            *folders, last = (step.split("`") for step in walk.split(" → "))
            folder = ROOT.joinpath(*(step[1] for step in folders))
            names = last[1::2]
            assert names, question
            assert all((folder / name).exists() for name in names), (question, walk)
