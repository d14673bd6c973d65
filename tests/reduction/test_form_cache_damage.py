"""Kernels that were damaged after they were compiled, with the form compiler itself."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

import solidwhirl.console.doctor as doctor
from solidwhirl.reduction.errors import KernelCacheError
from solidwhirl.reduction.operators.form_cache import guard_compiler

pytestmark = pytest.mark.solver
_COMPILE = """
import h5py, solidwhirl.reduction.operators.compat as compat, ufl
from mpi4py import MPI
import dolfinx.mesh
mesh = dolfinx.mesh.create_unit_square(MPI.COMM_WORLD, 1, 1)
measure = ufl.dx(domain=mesh)
print(compat.assembled_number(compat.compiled(compat.constant(mesh, 2.0) * measure)))
"""


def compiled(folder):
    return subprocess.run(
        [sys.executable, "-c", _COMPILE],
        env={**os.environ, "XDG_CACHE_HOME": str(folder)},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    folder = tmp_path_factory.mktemp("kernels")
    done = compiled(folder)
    assert done.stdout == "2.0\n", done.stderr
    return folder


def _cut(library):
    library.write_bytes(library.read_bytes()[: library.stat().st_size // 2])


def _cut_foreign(library):
    _cut(library)
    library.with_name(library.name + ".sha256").unlink()


def _flip(library):
    content = bytearray(library.read_bytes())
    content[len(content) // 2] ^= 1
    library.write_bytes(content)


def _folder(library):
    library.unlink()
    library.mkdir()


def _half_compiled(library):
    """What a program that was killed while it compiled leaves."""
    source = library.with_name(library.name.partition(".")[0] + ".c")
    for path in source.parent.glob(f"{source.stem}.*"):
        path.unlink()
    source.touch()
    os.utime(source, (time.time() - 60.0,) * 2)


def _without_source(library):
    library.with_name(library.name.partition(".")[0] + ".c").unlink()


DAMAGES = [_cut, _cut_foreign, _flip, _folder, _half_compiled, _without_source, Path.unlink]


@pytest.mark.parametrize("damage", [*DAMAGES, lambda path: path.write_bytes(b"")])
def test_damaged_kernel_is_found(cache, tmp_path, damage, monkeypatch):
    shutil.copytree(cache / "fenics", tmp_path / "fenics")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert doctor.kernel_cache().state == "ok"
    damage(next((tmp_path / "fenics").glob("libffcx_forms_*.so")))
    found = doctor.kernel_cache()
    assert (found.state, "1 damaged" in found.found) == ("doubtful", True)


RARE = [pytest.param(d, marks=pytest.mark.verify) for d in DAMAGES if d is not _flip]


@pytest.mark.parametrize("damage", [_flip, *RARE])
def test_damaged_kernel_is_compiled_again(cache, damage, monkeypatch):
    damage(next((cache / "fenics").glob("libffcx_forms_*.so")))
    done = compiled(cache)
    assert done.stdout == "2.0\n", done.stderr
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    assert doctor.kernel_cache().state == "ok"


def test_cache_that_is_no_folder_is_named(tmp_path, monkeypatch):
    from types import SimpleNamespace

    (tmp_path / "fenics").write_text("a file")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert doctor.kernel_cache().remedy == f"rm {tmp_path / 'fenics'}"

    def compile_forms(forms, *, cache_dir):
        cache_dir.mkdir(parents=True, exist_ok=True)

    module = SimpleNamespace(compile_forms=compile_forms)
    guard_compiler(module)
    with pytest.raises(KernelCacheError, match=r"fenics is not a folder.*remove it"):
        module.compile_forms([], cache_dir=tmp_path / "fenics")
