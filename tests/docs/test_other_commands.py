"""Every command of the documentation is run, or listed here with the reason why not.

The pages in FOLLOWED are run block by block in test_commands.py.
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
from typer.testing import CliRunner

from solidwhirl.cli import app

ROOT = Path(__file__).resolve().parents[2]
BIN = Path(sys.executable).parent
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").glob("*.md")])
FOLLOWED = ("README.md", "docs/tutorial.md", "docs/howto.md")
FENCE = re.compile(
    r"^(?:<!-- (test[^>]*?) -->\n)?```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE
)
RUN = r"(?:mpirun [^`\n]*)?(?:\.venv/bin/)?"
# a command with its arguments in running text; `solidwhirl check` alone is a name
INLINE = re.compile(rf"`({RUN}solidwhirl [a-z]+ [^`\n]+)`")

# Page -> commands run with all tests, in the folder that `beams` makes, in this order.
ORDINARY = {
    "CHANGELOG.md": ("solidwhirl schema scene", "solidwhirl schema results"),
    "docs/checks.md": (
        "solidwhirl check bodies/fan.h5",
        "solidwhirl check out/ferraris",
        "solidwhirl check a.h5 b.h5 --json",
    ),
    "docs/cluster.md": ("solidwhirl batch scenes/sweep.toml --out out/sweep --slurm sweep.sh",),
    "docs/export.md": (
        "solidwhirl export out/ferraris/bodies/inner.h5 --format dmig -o inner.pch",
        "solidwhirl formats",
    ),
    "docs/export_matrices.md": (
        "solidwhirl export bodies/fan.h5 --format dmig -o fan.pch",
        "solidwhirl export bodies/fan.h5 --format op4 -o fan.op4",
        "solidwhirl export bodies/fan.h5 --format matrix-market -o fan",
        "solidwhirl export bodies/fan.h5 --format npz -o fan.npz --speed-rpm 9000",
    ),
    "docs/export_multibody.md": (
        "solidwhirl export inner.h5 --format sid -o inner.SID_FEM",
        "solidwhirl export inner.h5 --format mbdyn -o inner.fem",
    ),
    "docs/export_python.md": (
        "solidwhirl export inner.h5 --format exudyn --out inner.py",
        "solidwhirl export inner.h5 --format exudyn-frame --speed-rpm 9000 --out inner_frame.py",
        "solidwhirl export inner.h5 --format ross --out inner_ross.py",
    ),
    "docs/meshes.md": (
        "solidwhirl geometry scenes/ferraris.toml --step ferraris.step",
        "solidwhirl geometry scenes/uhbr_engine.toml --step out/step --length-unit m",
    ),
    "docs/recovery.md": ("solidwhirl export out/bodies/rotor.h5 --format vtu -o rotor.vtu",),
    "docs/scene.md": ("solidwhirl schema scene", "solidwhirl schema results"),
    "docs/superelement.md": (
        "solidwhirl check BODY.h5",
        "solidwhirl export BODY.h5 --format json -o FILE.json",
    ),
    "docs/tutorial.md": ("solidwhirl init twin.toml --kind twin",),
}
# Names that the pages give to a body: the inner rotor of out/ferraris stands for all of them.
BODIES = ("bodies/fan.h5", "a.h5", "b.h5", "inner.h5", "out/bodies/rotor.h5", "BODY.h5")

# Page -> commands run as typed by `make verify`, in a folder of the page, in this order.
LONG = {
    "README.md": (
        "mpirun -n 2 .venv/bin/solidwhirl batch scenes/sweep.toml --out out/sweep "
        "--operating-rpm 8500 9000",
        'make batch SCENES="laval ferraris" NP=2',
    ),
    "docs/batch_pictures.md": (
        "solidwhirl batch scenes/sweep.toml --out out/sweep --operating-rpm 8500 9000",
        "solidwhirl batch-pictures out/sweep --operating-rpm 8000 9500",
    ),
    "docs/batch.md": (
        ".venv/bin/solidwhirl batch scenes/sweep.toml --out out/sweep",
        "mpirun -n 4 .venv/bin/solidwhirl batch scenes/laval.toml scenes/sweep.toml --out out/both "
        "--ranks-per-scene 2",
        ".venv/bin/solidwhirl batch scenes/sweep.toml --out out/sweep --resume",
        ".venv/bin/solidwhirl batch-pictures out/sweep --operating-rpm 8500 9000",
    ),
    "docs/cluster.md": (
        "solidwhirl batch scenes/laval.toml scenes/ferraris.toml --out out/batch",
        "mpirun -n 8 solidwhirl batch scenes/sweep.toml --out out/sweep",
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
    "docs/study.md": (
        ".venv/bin/solidwhirl study scenes/laval.toml --out out/study/laval --quick",
        ".venv/bin/solidwhirl study scenes/laval.toml --out out/study/laval",
    ),
    "docs/verification.md": (
        ".venv/bin/solidwhirl run free_rotor.toml --out out/free_rotor",
        ".venv/bin/solidwhirl run scenes/ferraris.toml --accuracy 1e-5 "
        "--out out/ferraris_converged",
        ".venv/bin/solidwhirl run scenes/ferraris.toml --out out/ferraris",
        ".venv/bin/solidwhirl run scenes/ferraris.toml --level solid --out out/ferraris_solid",
        ".venv/bin/solidwhirl run scenes/ferraris_paper.toml --out out/ferraris_paper",
        ".venv/bin/solidwhirl run scenes/laval.toml --out out/laval",
    ),
}
# Runs that a page takes for granted, before its first command.
BEFORE = {"docs/pictures.md": "solidwhirl run scenes/ferraris.toml --out out/ferraris"}

INSTALLS = "installs, which comes before the tests"
SUITE = "is the tests, or the checks beside them"
CONTAINER = "builds a Debian of its own, as root and from the network"
MEASURES = "measures time, minutes to hours; what it measured is in the page"
DRY = "hours of the command `run` or `study`; what it would start is tested below"
NOT_RUN = {
    "make pipeline": INSTALLS,
    ". .venv/bin/activate": "changes the shell of the reader; the tests run inside .venv",
    "make test": SUITE,
    "make check": SUITE,
    "make verify": SUITE,
    "make docs": "test_site.py builds the same site",
    ".venv/bin/python -m pytest tests/rotordyn/beams/test_published_rotors.py": SUITE,
    ".venv/bin/python -m pytest -q tests/program/test_injected_faults.py": SUITE,
    "sudo tools/in_debian.sh trixie make check": CONTAINER,
    "sudo SOLIDWHIRL_FILES=working tools/in_debian.sh trixie .venv/bin/python -m pytest "
    "tests/reduction": CONTAINER,
    ".venv/bin/python bench/refinement.py --count 300 --out refinement.jsonl": MEASURES,
    ".venv/bin/python bench/against_general_solver.py --count 2000": MEASURES,
    ".venv/bin/python bench/refinement.py --table refinement.jsonl": MEASURES,
    "make bench": MEASURES,
    ".venv/bin/python bench/multigrid.py --fit": MEASURES,
    ".venv/bin/python bench/multigrid.py --reuse --fit": MEASURES,
    ".venv/bin/python bench/ranks.py --small": MEASURES,
    ".venv/bin/python bench/ranks.py --small --iterative": MEASURES,
    ".venv/bin/python bench/effectivity.py": MEASURES,
    ".venv/bin/python bench/dial.py": MEASURES,
    ".venv/bin/python bench/engine.py": MEASURES,
    ".venv/bin/python bench/engine.py scenes/ferraris.toml": MEASURES,
    ".venv/bin/python bench/peers.py": MEASURES,
    ".venv/bin/python bench/peers.py --fresh": MEASURES,
    ".venv/bin/python bench/scaling.py": MEASURES,
    ".venv/bin/python bench/scaling.py --fit": MEASURES,
    "make scenes": DRY,
    "make study": DRY,
    "make study SCENE=uhbr_engine": DRY,
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
REGISTERED = app.registered_commands


def name_of(page):
    return str(page.relative_to(ROOT))


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


@pytest.fixture(scope="module")
def beams(tmp_path_factory):
    """Folder with the scenes, with a run of the twin rotor as beams, and with its inner rotor."""
    folder = tmp_path_factory.mktemp("beams")
    with_tree(folder)
    run = ["run", str(ROOT / "scenes" / "ferraris.toml"), "--level", "beam", "--no-pictures"]
    done = CliRunner().invoke(app, [*run, "--out", str(folder / "out" / "ferraris")])
    assert done.exit_code == 0, done.output
    for name in BODIES:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / "out" / "ferraris" / "bodies" / "inner.h5", folder / name)
    return folder


@pytest.mark.parametrize("page", ORDINARY)
def test_cheap_commands(page, beams, monkeypatch):
    monkeypatch.chdir(beams)
    for line in ORDINARY[page]:
        done = CliRunner().invoke(app, shlex.split(line)[1:])
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
    for _, language, text in FENCE.findall((ROOT / page).read_text(encoding="utf-8")):
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


def test_every_command_of_every_page_is_run_or_listed():
    """And what is listed is on a page: nothing is run that nobody reads."""
    unknown, seen = [], set()
    for page in PAGES:
        name = name_of(page)
        run = {*ORDINARY.get(name, ()), *LONG.get(name, ())}
        lines = set(commands_of(page.read_text(encoding="utf-8"), name in FOLLOWED))
        unknown += [f"{name}: {line}" for line in sorted(lines - run - set(NOT_RUN))]
        seen |= lines
        assert run <= lines, f"{name} does not show {sorted(run - lines)}"
    assert not unknown, "add to ORDINARY, LONG or NOT_RUN: " + "; ".join(unknown)
    assert set(NOT_RUN) <= seen, sorted(set(NOT_RUN) - seen)


@pytest.mark.parametrize("page", PAGES, ids=name_of)
def test_commands_stand_in_sh_blocks(page):
    """Elsewhere, or in a block that is indented, they would not be found."""
    assert not re.search(r"^ +(?:```|~~~)|^~~~", page.read_text(encoding="utf-8"), re.MULTILINE)
    names = "|".join(command.name or command.callback.__name__ for command in REGISTERED)
    for _, language, block in FENCE.findall(page.read_text(encoding="utf-8")):
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
