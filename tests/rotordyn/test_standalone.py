"""The stage works where none of the finite element and mesh libraries can be imported."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest
from rotors import three_disk_element

from solidwhirl.rotordyn import write_superelement

BLOCKED = ("dolfinx", "ufl", "petsc4py", "slepc4py", "mpi4py", "gmsh", "meshio", "matplotlib")

PROGRAM = """
import sys
for name in {blocked}:
    sys.modules[name] = None
import numpy as np
from solidwhirl.rotordyn import campbell
from solidwhirl.rotordyn import Bearing, End, Rotor, assemble, read_superelement
element = read_superelement({path!r})
supports = tuple(
    Bearing(name=n, first=End(body="r", interface=n), stiffness_n_per_m=7e7 * np.eye(2))
    for n in ("left", "right")
)
system = assemble({{"r": Rotor(element=element, speed_ratio=1.0)}}, supports)
diagram = campbell(system, [0.0, 500.0, 1000.0], branch_count=4)
print(diagram.frequency_hz.shape, sorted(set(diagram.whirl[:, -1].tolist())))
stages = ("geometry", "meshing", "reduction")
print([m for m in sys.modules if m.startswith("solidwhirl.") and m.split(".")[1] in stages])
"""


def run_in(folder, program):
    """Run a program by itself, warnings being errors."""
    return subprocess.run(
        [sys.executable, "-W", "error", "-c", program],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=folder,
    )


def test_reads_a_file_and_computes_without_other_libraries(tmp_path):
    path = tmp_path / "rotor.h5"
    write_superelement(three_disk_element(), path)
    program = PROGRAM.format(blocked=BLOCKED, path=str(path))
    done = run_in(tmp_path, program)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["(4, 3) ['backward', 'forward']", "[]"]


def test_only_known_libraries_are_named_in_the_sources():
    import solidwhirl.rotordyn

    folder = Path(solidwhirl.rotordyn.__file__).parent
    allowed = {"numpy", "scipy", "h5py", "matplotlib", "solidwhirl"}
    for source in folder.rglob("*.py"):
        tree = ast.parse(source.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module] if isinstance(node, ast.ImportFrom) else []
            for name in names:
                top = name.split(".")[0]
                assert top in allowed or top in sys.stdlib_module_names, (source.name, name)
                if top == "matplotlib":
                    assert source.parent.name == "plots" and node not in tree.body, source.name
                if top == "solidwhirl":
                    assert f"{name}.".startswith("solidwhirl.rotordyn."), (source.name, name)


@pytest.mark.parametrize("package", ["rotordyn", "rotordyn.superelement", "meshing"])
def test_every_name_of_a_package_that_imports_later_is_there(package):
    found = importlib.import_module(f"solidwhirl.{package}")
    assert all(hasattr(found, name) for name in found.__all__)
    assert set(found.__all__) <= set(dir(found))
    with pytest.raises(AttributeError, match="has no attribute 'nonsense'"):
        _ = found.nonsense


def test_a_function_is_not_hidden_by_the_modules_of_its_name(tmp_path):
    program = (
        "from solidwhirl.rotordyn import assemble\n"
        "import solidwhirl.rotordyn.campbell.tracking, solidwhirl.rotordyn.critical_speeds.search\n"
        "from solidwhirl.rotordyn import campbell, critical_speeds\n"
        "print(campbell.__name__, critical_speeds.__name__)\n"
    )
    done = run_in(tmp_path, program)
    assert done.stdout == "campbell critical_speeds\n", done.stderr
