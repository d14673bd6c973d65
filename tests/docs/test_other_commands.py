"""Every command of the documentation is run, or listed here with the reason why not.

Marked ones of the pages in FOLLOWED: in test_commands.py.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from pages import FENCE, FOLLOWED, PAGES, ROOT, blocks, name_of
from typer.testing import CliRunner

from solidwhirl.cli import app, every_command
from solidwhirl.output.documents import write_results
from solidwhirl.pipeline.run import run_scene
from solidwhirl.scene_reading.reader import read_scene

BIN = Path(sys.executable).parent
RUN = r"(?:mpirun [^`\n]*)?(?:\.venv/bin/)?"
# a command with its arguments in running text; `solidwhirl check` alone is a name
INLINE = re.compile(rf"`({RUN}solidwhirl [a-z]+ [^`\n]+)`")

# Names that the pages give to a body: the inner rotor of out/ferraris stands for all of them.
BODIES = ("bodies/fan.h5", "a.h5", "b.h5", "inner.h5", "out/bodies/rotor.h5", "BODY.h5")

# Page -> commands run as typed by `make verify`, in a folder of the page, in this order, whatever
# other page has them too. What is neither here nor in NOT_RUN is run with all tests, in the folder
# that `beams` makes.
LONG = {
    "README.md": ('make batch SCENES="laval ferraris" NP=2',),
    "docs/batch.md": (
        ".venv/bin/solidwhirl batch scenes/sweep.toml --out out/sweep",
        "mpirun -n 4 .venv/bin/solidwhirl batch scenes/laval.toml scenes/sweep.toml --out out/both "
        "--ranks-per-scene 2",
        ".venv/bin/solidwhirl batch scenes/sweep.toml --out out/sweep --resume",
        ".venv/bin/solidwhirl batch-pictures out/sweep --operating-rpm 8500 9000",
    ),
    "docs/cluster.md": (
        "mpirun -n 8 solidwhirl batch scenes/own_mesh.toml scenes/casing.toml --out out/two "
        "--ranks-per-scene 4",
        'make batch SCENES="laval ferraris" NP=2 K=1 OUT=out/batch',
    ),
    "docs/howto.md": ("mpirun -n 2 solidwhirl run SCENE.toml --level solid --out DIR",),
    "docs/identify.md": (
        ".venv/bin/solidwhirl identify scenes/identify/uhbr_lp.toml "
        "--out out/identify/uhbr_lp.toml",
    ),
    "docs/pictures.md": (
        "solidwhirl pictures scenes/ferraris.toml --out out/ferraris --formats pdf,svg",
        "solidwhirl pictures scenes/ferraris.toml --out out/ferraris --formats gif "
        "--only mode_critical_1_film",
    ),
    "docs/verification.md": (
        ".venv/bin/solidwhirl run free_rotor.toml --out out/free_rotor",
        ".venv/bin/solidwhirl run scenes/ferraris.toml --accuracy 1e-5 "
        "--out out/ferraris_converged",
        ".venv/bin/solidwhirl run scenes/ferraris.toml --level solid --out out/ferraris_solid",
    ),
}
# Runs that a page takes for granted, before its first command.
BEFORE = {"docs/pictures.md": "solidwhirl run scenes/ferraris.toml --out out/ferraris"}

INSTALLS = "installs, which comes before the tests"
SUITE = "is the tests, or the checks beside them"
CONTAINER = "builds a Debian of its own, as root and from the network"
MEASURES = "measures time, minutes to hours; what it measured is in the page"
DRY = "hours of the command `run` or `study`; what it would start is tested below"
SERVES = "serves a page until it is ended; tests/program/watch"
HELP = "an example of the help, which tests/program/commands runs"
SCENE = "a scene as it is written, which tests/program/pipeline/test_scenes.py runs"
TWICE = "the same batch is run for docs/batch.md on one rank and four, for the help on two"
GUIDE = "tools/guide_pictures.py runs the scene of the page for its pictures, minutes"
# Beginning of a command -> why it is not run.
NOT_RUN = {
    "make pipeline": INSTALLS,
    ". .venv/bin/activate": "changes the shell of the reader; the tests run inside .venv",
    "tools/setup.sh ": INSTALLS,
    "python3 -m venv .venv": INSTALLS,
    ".venv/bin/pip install ": INSTALLS,
    ".venv/bin/solidwhirl doctor": "of an environment made anew; `solidwhirl doctor` is run",
    "solidwhirl plan wheel.toml": GUIDE,
    "solidwhirl run wheel.toml": GUIDE,
    "solidwhirl pictures wheel.toml": GUIDE,
    "solidwhirl watch ": SERVES,
    "solidwhirl run scenes/keyway_shaft.toml ": SCENE,
    "solidwhirl run scenes/two_pole_generator.toml ": SCENE,
    "solidwhirl run scenes/two_bladed_fan.toml ": SCENE,
    "solidwhirl run scenes/crank_mesh.toml ": SCENE,
    ".venv/bin/solidwhirl run scenes/ferraris.toml --out out/ferraris": SCENE,
    ".venv/bin/solidwhirl run scenes/ferraris_paper.toml --out out/ferraris_paper": SCENE,
    ".venv/bin/solidwhirl run scenes/laval.toml --out out/laval": SCENE,
    "solidwhirl batch scenes/sweep.toml --out out/sweep --operating-rpm ": TWICE,
    "solidwhirl batch-pictures out/sweep --operating-rpm 8000 ": TWICE,
    "mpirun -n 8 solidwhirl batch scenes/sweep.toml ": TWICE,
    "mpirun -n 2 .venv/bin/solidwhirl batch scenes/sweep.toml --out out/sweep --operating": TWICE,
    "make test": SUITE,
    "make check": SUITE,
    "make verify": SUITE,
    "make docs": "test_site.py builds the same site",
    ".venv/bin/python -m pytest ": SUITE,
    "sudo tools/in_debian.sh ": CONTAINER,
    "sudo SOLIDWHIRL_FILES=working tools/in_debian.sh ": CONTAINER,
    ".venv/bin/python bench/": MEASURES,
    "make bench": MEASURES,
    "make scenes": DRY,
    "make study": DRY,
    ".venv/bin/solidwhirl study scenes/laval.toml ": HELP,
    "solidwhirl doctor --calibrate": HELP,
    "solidwhirl batch scenes/laval.toml scenes/ferraris.toml --out out/batch": HELP,
    ".venv/bin/solidwhirl study scenes/reference_solid.toml": DRY,
    ".venv/bin/solidwhirl study scenes/bladed_disk.toml": DRY,
    "solidwhirl bearing --from-ross ": "needs ROSS; tests/verify/test_maker_tables.py runs it",
    "sbatch sweep.sh": "needs Slurm;"
    " tests/program/batch/test_batch.py runs such a script without it",
}
# ranks as root, and more of them than cores
MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
}


def commands_of(text, followed):
    """Command lines of a page, without comments; of a followed page those not marked as tests."""
    found = []
    for mark, language, block in FENCE.findall(text):
        if language == "sh" and not (followed and mark):
            found += [re.sub(r"\s+#.*|^#.*", "", line).strip() for line in block.splitlines()]
    return [line for line in [*found, *INLINE.findall(FENCE.sub("", text))] if line]


def run_in_shell(line, folder, **more):
    """Run a line as typed, with the program that is tested; what it printed."""
    path = {"PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}
    done = subprocess.run(
        ["sh", "-c", line],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=3600,
        check=False,
        env=os.environ | path | MPI | {"OPENBLAS_NUM_THREADS": "1"} | more,
    )
    assert done.returncode == 0, f"{line}\n{done.stdout}"
    return done.stdout


def assert_written(line, folder):
    """What the command was to write is there, and is not empty."""
    words = shlex.split(line)
    for option in ("-o", "--out", "--step", "--slurm"):
        # a script for Slurm is all that is written then
        if option in words and not (option == "--out" and "--slurm" in words):
            path = folder / words[words.index(option) + 1]
            files = [path] if path.is_file() else list(path.rglob("*")) if path.is_dir() else []
            # matrix-market takes the name as the beginning of the names of its files
            files = files or list(path.parent.glob(f"{path.name}[._]*"))
            assert any(file.is_file() and file.stat().st_size for file in files), line


def with_tree(folder):
    """Give a folder what the commands find beside them in the tree: all but results."""
    for path in ROOT.iterdir():
        if path.name not in ("out", "build", ".git", ".venv"):
            (folder / path.name).symlink_to(path, target_is_directory=path.is_dir())
    (folder / ".venv").mkdir()
    (folder / ".venv" / "bin").symlink_to(BIN, target_is_directory=True)
    shutil.copy(ROOT / "scenes" / "laval.toml", folder / "SCENE.toml")


ANY_LONG = {line for lines in LONG.values() for line in lines}


@pytest.fixture(scope="module")
def beams(tmp_path_factory):
    """Folder with the scenes, with a run of the twin rotor as beams, and with its inner rotor."""
    folder = tmp_path_factory.mktemp("beams")
    with_tree(folder)
    scene = read_scene(ROOT / "scenes" / "ferraris.toml")
    model = scene.model.model_copy(update={"level": "beam", "estimates": "off"})
    results = run_scene(scene.model_copy(update={"model": model, "analyses": ()}))
    write_results(results, folder / "out" / "ferraris", pictures=False)
    for name in BODIES:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / "out" / "ferraris" / "bodies" / "inner.h5", folder / name)
    return folder


def cheap(page):
    """Commands of a page that are run with all tests."""
    told = commands_of(page.read_text(encoding="utf-8"), name_of(page) in FOLLOWED)
    return [line for line in told if line not in ANY_LONG and not line.startswith(tuple(NOT_RUN))]


@pytest.mark.parametrize("page", [page for page in PAGES if cheap(page)], ids=name_of)
def test_cheap_commands(page, beams, monkeypatch):
    monkeypatch.chdir(beams)
    for line in cheap(page):
        program, *arguments = shlex.split(line)
        assert program == "solidwhirl", f"add to LONG, or to NOT_RUN with the reason: {line}"
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, f"{line}\n{done.output}"
        assert_written(line, beams)


@pytest.fixture(scope="module")
def stages(tmp_path_factory):
    """Store of completed stages: several pages run the same scenes."""
    return str(tmp_path_factory.mktemp("stages"))


@pytest.mark.verify
@pytest.mark.solver
@pytest.mark.mpi
@pytest.mark.parametrize("page", LONG)
def test_long_commands(page, tmp_path, stages):
    with_tree(tmp_path)
    for _, language, text in blocks(page):
        if language == "toml" and (named := re.match(r"# (\S+\.toml)\n", text)):
            (tmp_path / named[1]).write_text(text)
    if page in BEFORE:
        run_in_shell(BEFORE[page], tmp_path, SOLIDWHIRL_STORE=stages)
    for line in LONG[page]:
        # nothing is installed by a test
        typed = re.sub(r"^make ", "make -o setup ", line)
        run_in_shell(typed, tmp_path, SOLIDWHIRL_STORE=stages)
        if not line.startswith("make"):
            assert_written(line, tmp_path)


@pytest.mark.parametrize(
    ("target", "starts"),
    [
        ("scenes", [f"run scenes/{name}.toml --out out/{name}" for name in ("laval", "uhbr_lp")]),
        ("study", ["study scenes/ferraris.toml --out out/study/ferraris"]),
    ],
)
def test_make_would_start_what_the_pages_say(target, starts, tmp_path):
    with_tree(tmp_path)
    printed = run_in_shell(f"make -n -o setup {target}", tmp_path)
    for command in starts:
        assert f".venv/bin/solidwhirl {command}" in printed


def test_what_is_listed_is_on_a_page():
    """So nothing is listed, or run, that nobody reads."""
    told = {
        name_of(page): set(commands_of(page.read_text(encoding="utf-8"), name_of(page) in FOLLOWED))
        for page in PAGES
    }
    for name, lines in LONG.items():
        assert set(lines) <= told[name], f"{name} does not show {sorted(set(lines) - told[name])}"
    everywhere = set().union(*told.values())
    assert not [n for n in NOT_RUN if not any(line.startswith(n) for line in everywhere)]


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_stand_in_sh_blocks(page):
    """Elsewhere, or in a block that is indented, they would not be found."""
    assert not re.search(r"^ +(?:```|~~~)|^~~~", page.read_text(encoding="utf-8"), re.MULTILINE)
    names = "|".join(every_command())
    for _, language, block in blocks(page):
        if language != "sh":
            found = re.search(rf"^\W*{RUN}solidwhirl (?:{names})\b", block, re.MULTILINE)
            assert found is None, found[0]


def test_a_new_command_would_be_found():
    page = (
        "Text `solidwhirl check NEW.h5` and `solidwhirl run` alone.\n"
        "```sh\nmpirun -n 2 solidwhirl run a.toml --out a   # why\n# a remark\n```\n"
        "<!-- test -->\n```sh\nsolidwhirl plan a.toml\n```\n"
    )
    found = ["mpirun -n 2 solidwhirl run a.toml --out a", "solidwhirl check NEW.h5"]
    assert commands_of(page, True) == found
    assert commands_of(page, False) == [found[0], "solidwhirl plan a.toml", found[1]]
