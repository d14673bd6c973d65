"""`solidwhirl doctor`: what is there, what is missing, and what installs it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from functools import partial
from itertools import product
from pathlib import Path

import pytest

import solidwhirl.console.doctor as doctor
from solidwhirl.console.doctor import Finding, apt, examine, exit_code, pip, report_lines

PROGRAM = str(Path(sys.executable).parent / "solidwhirl")


def started(*command, **more):
    """A command as a user starts it, with other variables."""
    return subprocess.run(
        command,
        env={**os.environ, **more},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def finding(name, found):
    return next(one for one in found if one.what.split(" (")[0] == name)


@pytest.fixture(scope="module")
def incomplete(tmp_path_factory):
    """What the command finds without dolfinx, and where gmsh lacks a library of the system."""
    folder = tmp_path_factory.mktemp("modules")
    (folder / "dolfinx.py").write_text(
        "raise ModuleNotFoundError(\"No module named 'dolfinx'\", name='dolfinx')\n"
    )
    (folder / "gmsh.py").write_text(
        "raise OSError('libGLU.so.1: cannot open shared object file: No such file')\n"
    )
    (folder / "slepc4py.py").write_text("import os\nos.abort()\n")
    path = os.pathsep.join(filter(None, (str(folder), os.environ.get("PYTHONPATH"))))
    places = {"PYTHONPATH": path, "SOLIDWHIRL_STORE": "/dev/null/store"}
    return started(PROGRAM, "doctor", "--json", **places), path


@pytest.mark.solver
def test_missing_modules_are_told(incomplete):
    """By the command as a user starts it, which still works without dolfinx."""
    done, _ = incomplete
    assert done.returncode == 1, done.stderr
    assert done.stderr == ""
    found = json.loads(done.stdout)
    assert found["exit_code"] == 1
    by_name = {one["what"].split(" (")[0]: one for one in found["findings"]}
    assert by_name["dolfinx"]["state"] == "missing"
    assert "No module named 'dolfinx'" in by_name["dolfinx"]["found"]
    assert by_name["gmsh"]["remedy"] == apt("libglu1-mesa")
    assert by_name["slepc4py"]["state"] == "missing"  # it ends its process, not this one
    assert by_name["petsc4py"]["state"] == "ok"
    assert by_name["petsc4py"]["found"].startswith("3.")
    assert by_name["numpy"]["state"] == "ok"
    assert by_name["store of stages"]["remedy"] == "unset SOLIDWHIRL_STORE"


@pytest.mark.solver
def test_run_without_the_library_points_to_the_doctor(incomplete, root, tmp_path):
    scene = str(root / "scenes" / "laval.toml")
    words = ("run", "--out", str(tmp_path / "o"), "--level", "harmonic", scene)
    done = started(PROGRAM, *words, "--json", PYTHONPATH=incomplete[1])
    assert done.returncode == json.loads(done.stdout)["exit_code"] == 2
    assert "Traceback" not in done.stderr
    assert "`solidwhirl doctor` says what is missing" in done.stderr.splitlines()[-1]


def test_script_needs_the_standard_library_alone():
    """Isolated and without site-packages nothing else can be imported."""
    done = started(sys.executable, "-I", "-S", str(doctor.__file__), PYTHONPATH="")
    # the modules that it tries are found by processes that are not isolated
    assert done.returncode == 1, done.stderr
    assert re.search(r"^MISSING +numpy", done.stdout, re.MULTILINE)
    assert done.stderr == ""


@pytest.fixture
def quick(monkeypatch):
    """Compiled modules are not tried."""
    monkeypatch.setattr(doctor, "compiled_modules", lambda: iter(()))


def test_exit_code_counts_what_is_needed(quick):
    found = examine()
    needed = [one for one in found if one.needed]
    assert found[: len(needed)] == tuple(needed)
    for state, is_needed in product(("ok", "doubtful", "missing"), (False, True)):
        one = Finding(what="a", state=state, found="", needed=is_needed)
        assert exit_code([one]) == (state == "missing" and is_needed)


def test_commands_are_put_together():
    missing = partial(Finding, state="missing", found="")
    found = [
        missing(what="a", remedy=apt("python3-a")),
        missing(what="b", remedy=pip("b>=1,<2")),
        missing(what="c", remedy=apt("c1", "c2")),
        missing(what="d", needed=False, remedy=apt("d")),
        Finding(what="e", state="ok", found="3"),
    ]
    lines = list(report_lines(found))
    assert f"  {apt('python3-a', 'c1', 'c2')}" in lines
    assert f"  {sys.executable} -m pip install 'b>=1,<2'" in lines
    assert lines.index(f"  {apt('d')}") > lines.index("For comfort:")
    assert "make setup" in lines[-1]


def test_versions_are_compared_with_those_of_the_project(quick, monkeypatch):
    """Of packages that are there; of others it counts whether they are needed."""
    real = doctor.metadata.version
    monkeypatch.setattr(
        doctor.metadata, "version", lambda name: "1.0" if name == "pydantic" else real(name)
    )
    one = finding("pydantic", examine())
    assert one.state == "doubtful"
    assert one.found.startswith("1.0, tested with ")
    assert one.remedy.startswith(f"{sys.executable} -m pip install 'pydantic")

    def version(name):
        raise doctor.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(doctor.metadata, "version", version)
    found = examine()
    jinja = finding("jinja2", found)
    assert jinja.needed and jinja.state == "missing"
    assert not finding("pyvista", found).needed
    assert exit_code(found) == 1


def test_programs_and_places(quick, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "8")
    monkeypatch.setenv("SOLIDWHIRL_STORE", str(tmp_path / "store"))
    monkeypatch.delenv("CC", raising=False)
    found = examine()
    compiler = finding("C compiler", found)
    assert (compiler.state, compiler.remedy) == ("missing", apt("gcc", "g++"))
    browser = finding("browser", found)
    assert (browser.state, browser.needed) == ("missing", False)
    assert finding("cores and threads", found).state == "doubtful"
    assert finding("store of stages", found).state == "ok"


def test_environment_that_does_not_see_debians_packages(monkeypatch):
    monkeypatch.setattr(doctor.Path, "exists", lambda self: True)
    monkeypatch.setattr(sys, "base_prefix", "/usr")
    monkeypatch.setattr(sys, "prefix", "/home/me/.venv")
    why = "ModuleNotFoundError: No module named 'dolfinx'"
    remedy = doctor.remedy_for("dolfinx", "python3-dolfinx", why)
    assert remedy == "/usr/bin/python3 -m venv --system-site-packages --upgrade /home/me/.venv"
    monkeypatch.setattr(doctor.Path, "exists", lambda self: False)
    assert doctor.remedy_for("dolfinx", "python3-dolfinx", why) == apt("python3-dolfinx")


def test_other_pythons_get_the_wheel(monkeypatch):
    """Debian's packages are for its own Python, and the wheel for 3.12 and later."""
    why = "ModuleNotFoundError: No module named 'petsc4py'"
    monkeypatch.setattr(doctor.Path, "exists", lambda self: False)
    for base, version, remedy in (
        ("/opt/python", (3, 13, 0), pip("dolfinx-solver-real")),
        ("/usr", (3, 13, 0), apt("python3-petsc4py")),
        ("/opt/python", (3, 11, 2), apt("python3-petsc4py")),
    ):
        monkeypatch.setattr(sys, "base_prefix", base)
        monkeypatch.setattr(sys, "version_info", version)
        assert doctor.remedy_for("petsc4py", "python3-petsc4py", why) == remedy
    said = doctor.remedy_for(
        "petsc4py", "python3-petsc4py", "PETSc is compiled for complex numbers"
    )
    assert said.endswith(pip("dolfinx-solver-real"))


@pytest.mark.solver
def test_the_wheel_puts_its_libraries_in_order_before_they_are_loaded(tmp_path):
    """By a stand-in for its module, which sees what is there when it is imported."""
    (tmp_path / "dolfinx_solver.py").write_text(
        "import sys\nprint(sorted({'petsc4py', 'slepc4py', 'dolfinx'} & set(sys.modules)))\n"
    )
    path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    program = "import solidwhirl.reduction, sys\nprint('dolfinx' in sys.modules)\n"
    done = started(sys.executable, "-c", program, PYTHONPATH=path)
    assert done.stdout.splitlines() == ["[]", "True"], done.stderr
