"""Who may import what: the stages stand apart and one file knows the library's versions."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

STAGES = ("geometry", "meshing", "reduction", "rotordyn")
LIBRARY = {"dolfinx", "ufl", "basix", "ffcx", "petsc4py", "slepc4py"}
# Names that dolfinx renamed or removed between 0.5 and 0.9 and those that replace them.
VERSIONED = {
    *("functionspace", "FunctionSpace", "VectorFunctionSpace", "FiniteElement", "VectorElement"),
    *("create_mesh", "gmshio", "distribute_entity_data", "petsc_vec"),
}
# One package a line, as the linter has it.
IMPORT = re.compile(r"^ *(?:from (\S+) import|import (\S+))", re.MULTILINE)
FROM_HERE = re.compile(r"^ *from (solidwhirl\S*) import (\([^)]*\)|.*)$", re.MULTILINE)
VERSIONED_ATTRIBUTES = {*VERSIONED, "vector"}  # `vector` is also a good name for a variable
BLOCKED = (*sorted(LIBRARY), "gmsh", "meshio", "mpi4py", "pydantic", "typer", "rich", "matplotlib")


def sources(root, *folders):
    found = [p for folder in folders for p in sorted((root / folder).rglob("*.py"))]
    assert found
    return found


@functools.cache
def nodes(path):
    """All parts of a source file."""
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


def imported(path):
    """Top-level packages that a file imports, anywhere in it."""
    found = {first or second for first, second in IMPORT.findall(path.read_text(encoding="utf-8"))}
    assert not [name for name in found if name.startswith(".")], f"{path}: relative import"
    return {name.split(".")[0] for name in found}


def versioned(path):
    """Version-dependent names that a file reads or imports, with their lines."""
    found = []
    for node in nodes(path):
        names = []
        if isinstance(node, ast.Attribute) and node.attr in VERSIONED_ATTRIBUTES:
            found.append((node.attr, node.lineno))
        if isinstance(node, ast.Name):
            names = [node.id]
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [part for alias in node.names for part in alias.name.split(".")]
        found += [(name, node.lineno) for name in names if name in VERSIONED]
    return found


def test_contracts_hold(root):
    """The contracts of pyproject.toml, by import-linter."""
    done = subprocess.run(
        [str(Path(sys.executable).parent / "lint-imports"), "--no-cache"],
        cwd=root,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 broken" in done.stdout
    assert "0 kept" not in done.stdout


def test_sources_import_stages_with_the_package_and_the_library_in_reduction_alone(root):
    """The tree lies open beside the package; one module under two names would be two modules."""
    users = set()
    for path in sources(root, *STAGES, "solidwhirl"):
        assert not imported(path) & set(STAGES), path
        if imported(path) & LIBRARY:
            users.add(path.relative_to(root).parts[0])
    assert users == {"reduction"}


# What comes with a package that is asked for, or from Debian or the extra `solver`; and what a
# written file imports elsewhere, or a function does without.
COME_ALONG = {
    *LIBRARY,
    *("mpi4py", "dolfinx_solver", "pydantic_core", "markupsafe", "PIL"),
    *("ross", "exudyn", "packaging"),
}


def test_every_package_that_is_imported_is_declared(root):
    """What a developer's tool brings along hides a missing one."""
    project = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]
    listed = [*project["dependencies"], *project["optional-dependencies"]["pipeline"]]
    declared = {re.match(r"[\w-]+", line)[0].replace("-", "_") for line in listed}
    found = {n.strip(",") for path in sources(root, *STAGES, "solidwhirl") for n in imported(path)}
    assert found - set(sys.stdlib_module_names) - {"solidwhirl"} <= declared | COME_ALONG


@pytest.mark.parametrize("words", [["run", "x.toml"], ["--help"]])
def test_without_the_command_line_s_packages_it_says_what_to_install(words, tmp_path):
    program = f"import sys\nsys.modules['typer'] = None\nsys.argv = ['solidwhirl', *{words!r}]\n"
    done = subprocess.run(
        [sys.executable, "-c", program + "import solidwhirl.__main__ as m\nm.main()"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("error: ") and "pip install '.[pipeline]'" in line


def printed_by(program, folder):
    """What a program prints in a process of its own, warnings being errors."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_what_is_imported_is_what_is_needed(root, tmp_path):
    """`solidwhirl plan` needs no finite element library, and does not wait for it to load.

    Each kind of analysis brings its computation along: the command line waits for none.
    """
    blocked = "import sys\nfor name in {!r}:\n    sys.modules[name] = None\n"
    program = (
        blocked.format(BLOCKED) + "import solidwhirl.rotordyn as rotordyn\n"
        "print(rotordyn.assemble.__module__)\n"
        f"print([s for s in {STAGES!r} if 'solidwhirl.' + s in sys.modules])\n"
    )
    lines = printed_by(program, tmp_path).splitlines()
    assert lines == ["solidwhirl.rotordyn.assembly.system", "['rotordyn']"]
    program = blocked.format((*sorted(LIBRARY), "mpi4py")) + (
        "import solidwhirl.cli\n"
        "print('solidwhirl.analyses' in sys.modules)\n"
        f"solidwhirl.cli.app(['plan', {str(root / 'scenes' / 'ferraris.toml')!r}])\n"
    )
    printed = printed_by(program, tmp_path)
    assert printed.startswith("False\n") and "stress_stiffening" in printed


def test_help_loads_neither_arrays_nor_records(tmp_path):
    unneeded = ["numpy", "scipy", "h5py", "pydantic", "matplotlib", "solidwhirl.scene"]
    program = (
        "import sys\nimport solidwhirl.cli\n"
        "solidwhirl.cli.app(['--help'], standalone_mode=False)\n"
        f"print([name for name in {unneeded!r} if name in sys.modules])\n"
    )
    assert printed_by(program, tmp_path).splitlines()[-1] == "[]"


def test_a_plan_of_a_given_level_loads_nothing_that_computes_or_draws(root, tmp_path):
    unneeded = [
        *("matplotlib", "plotly", "pyvista", "h5py", "scipy"),
        *(
            f"solidwhirl.rotordyn.{part}"
            for part in ("campbell", "response", "storage", "importing")
        ),
        *("solidwhirl.rotordyn.assembly.system", "solidwhirl.meshing.own.meridian"),
        # kinds that the scene does not ask for, and what others compute with
        *("solidwhirl.analyses.responses.run_up", "solidwhirl.analyses.recovery.states"),
    ]
    program = (
        "import sys\nimport solidwhirl.cli\nasked = ['--level', 'harmonic', '--json']\n"
        f"scene = {str(root / 'scenes' / 'ferraris.toml')!r}\n"
        "solidwhirl.cli.app(['plan', scene, *asked], standalone_mode=False)\n"
        f"print([name for name in {unneeded!r} if name in sys.modules])\n"
    )
    assert printed_by(program, tmp_path).splitlines()[-1] == "[]"


def test_runs_of_kept_bodies_load_no_mesher(tmp_path):
    unneeded = [
        *("gmsh", "meshio", "petsc4py", "scipy.spatial", "ssl"),
        *("solidwhirl.meshing.own.meridian", "solidwhirl.rotordyn.asymmetric.in_time"),
    ]
    program = (
        "import sys\nimport solidwhirl.pipeline.run, solidwhirl.output.documents\n"
        f"print([name for name in {unneeded!r} if name in sys.modules])\n"
    )
    assert printed_by(program, tmp_path).splitlines()[-1] == "[]"


def test_only_compat_uses_names_that_differ_between_versions(root):
    found = {path.name: versioned(path) for path in sources(root, "reduction") if versioned(path)}
    assert set(found) == {"compat.py"}, found
    # the scan sees what it is to see: the names for both versions stand in compat.py
    names = {name for name, _ in found["compat.py"]}
    assert {"functionspace", "FunctionSpace", "VectorFunctionSpace"} <= names


def test_no_test_imports_a_private_name(root):
    found = [
        f"{path.relative_to(root)}: {names} of {module}"
        for path in (root / "tests").rglob("*.py")
        for module, names in FROM_HERE.findall(path.read_text(encoding="utf-8"))
        # names that are given here may begin with anything
        if "._" in module or re.search(r"(?<! as )\b_\w", names)
    ]
    assert not found
