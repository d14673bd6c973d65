"""What an installation has and lacks, and the commands that install it; the standard library alone.

Also a program of its own, for where nothing else starts: `python3 solidwhirl/console/doctor.py`.
"""

from __future__ import annotations

import ctypes.util
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata, util
from pathlib import Path
from typing import Any, Literal

State = Literal["ok", "missing", "doubtful"]
_PYTHON = (3, 11)
_LEAST_MEMORY_GIB, _LEAST_DISK_GIB, _IMPORT_S = 1.0, 1.0, 300.0
# Compiled modules: what they are for, and Debian's package (None: from PyPI).
_COMPILED: Mapping[str, tuple[str, str | None]] = {
    "mpi4py.MPI": ("several ranks", "python3-mpi4py"),
    "petsc4py.PETSc": ("linear algebra", "python3-petsc4py"),
    "slepc4py.SLEPc": ("eigenvalues", "python3-slepc4py"),
    "dolfinx": ("finite elements", "python3-dolfinx"),
    "gmsh": ("meshes", None),
}
# Where Python is not Debian's, one wheel has those that do not come from PyPI by themselves.
_WHEEL = "dolfinx-solver-real"
# Packages of the extra `pipeline` that runs do without.
_OPTIONAL = {
    "pyvista": "pictures of solids",
    "imageio": "animations",
    "imageio-ffmpeg": "animations as MP4",
    "xarray": "results as labelled arrays",
    "tornado": "pages that follow a scene file",
}
_WITHOUT_METADATA = ("h5py", "matplotlib", "numpy", "plotly", "pydantic", "rich", "scipy", "typer")
# Shared libraries that gmsh's and VTK's wheels ask the system for.
_LIBRARIES = {
    **{"libGL.so": "libgl1", "libGLU.so": "libglu1-mesa", "libEGL.so": "libegl1"},
    **{f"libX{name}.so": f"libx{name}1" for name in ("render", "cursor")},
    **{"libXft.so": "libxft2", "libXinerama.so": "libxinerama1"},
}
# h5py's HDF5 has to come before that of dolfinx; the wheel puts its libraries in order.
_PROBE = """
import contextlib, importlib, sys
with contextlib.suppress(ImportError):
    import h5py
with contextlib.suppress(ModuleNotFoundError):
    import dolfinx_solver
found = importlib.import_module(sys.argv[1])
if issubclass(getattr(found, 'ScalarType', float), complex):
    sys.exit('is compiled for complex numbers; real ones are needed')
top = sys.modules[sys.argv[1].partition('.')[0]]
print('version', getattr(top, '__version__', ''))
"""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One thing that was looked for."""

    what: str
    state: State  #: "ok", "missing", or "doubtful" where it is there but will not do well
    found: str
    needed: bool = True
    remedy: str = ""


def examine() -> tuple[Finding, ...]:
    """Look for all that the program needs, in a few seconds; what is needed comes first."""
    found = [_python(), *_packages(), *compiled_modules(), _compiler(), kernel_cache()]
    found += [_memory(), _disk(), _threads(), _blas(), *_comforts()]
    return tuple(sorted(found, key=lambda one: not one.needed))


def exit_code(found: Sequence[Finding]) -> int:
    """Return 1 if something is missing that runs need, else 0."""
    return int(any(one.needed and one.state == "missing" for one in found))


def report_lines(found: Sequence[Finding]) -> Iterator[str]:
    """Say what was found, a line each, and the commands that install the rest."""
    width = max(len(one.what) for one in found)
    for one in found:
        word = ("MISSING" if one.needed else "not there") if one.state == "missing" else one.state
        yield f"{word:<9}  {one.what:<{width}}  {one.found}".rstrip()
    wanted = [one for one in found if one.state != "ok" and one.remedy]
    remedies = dict.fromkeys(one.remedy for one in wanted if one.needed)
    comforts = dict.fromkeys(one.remedy for one in wanted if not one.needed)
    more = [remedy for remedy in comforts if remedy not in remedies]
    for title, commands in (("What runs need:", list(remedies)), ("For comfort:", more)):
        if commands:
            yield from ("", title, *(f"  {command}" for command in _merged(commands)))
    yield ""
    if exit_code(found):
        yield (
            "Something is missing that runs need. On Debian, `make setup` installs all of it; "
            f"elsewhere, with Python 3.12 or later, `pip install {_WHEEL} '.[pipeline]'` does."
        )
    else:
        yield "All that runs need is there."


def report_document(found: Sequence[Finding]) -> dict[str, object]:
    """The findings as plain data."""
    return {
        "schema": "solidwhirl-doctor-1",
        "exit_code": exit_code(found),
        "findings": [{**asdict(one), "remedy": one.remedy or None} for one in found],
    }


def apt(*packages: str) -> str:
    """The command that installs Debian packages."""
    prefix = "" if os.geteuid() == 0 else "sudo "
    return " ".join([f"{prefix}apt-get install --no-install-recommends", *packages])


def pip(*requirements: str) -> str:
    """The command that installs packages from PyPI."""
    return " ".join([f"{sys.executable} -m pip install", *(repr(r) for r in requirements)])


def _merged(commands: Sequence[str]) -> Iterator[str]:
    """The commands, those of one installer as one."""
    together: dict[str, list[str]] = {}
    for command in commands:
        head = next((h for h in (apt(), pip()) if command.startswith(f"{h} ")), command)
        together.setdefault(head, []).append(command.removeprefix(head).strip())
    for head, tails in together.items():
        yield " ".join([head, *dict.fromkeys(tails)]).strip()


def _python() -> Finding:
    version, wanted = (".".join(map(str, n)) for n in (sys.version_info[:3], _PYTHON))
    found = version if sys.version_info >= _PYTHON else None
    what = f"Python {wanted} or later"
    return _seen(what, found, apt("python3", "python3-venv"), needed=True)


def _packages() -> Iterator[Finding]:
    """Packages of the project's own list; compiled ones are tried by importing them."""
    compiled = {name.partition(".")[0] for name in _COMPILED}
    for name, wanted in _requirements():
        if name in compiled:
            continue
        what = f"{name} ({use})" if (use := _OPTIONAL.get(name)) else name
        remedy = pip(name + wanted)
        try:
            version = metadata.version(name)
        except metadata.PackageNotFoundError:
            yield _seen(what, None, remedy, needed=use is None)
            continue
        fits = _fits(version, wanted)
        found = version if fits else f"{version}, tested with {wanted}"
        yield _seen(what, found, remedy, good=fits, needed=use is None)


def _requirements() -> list[tuple[str, str]]:
    """Names and versions that the project asks for to run scenes."""
    try:
        listed = metadata.requires("solidwhirl") or []
    except metadata.PackageNotFoundError:
        return [(name, "") for name in _WITHOUT_METADATA]
    found = []
    for line in listed:
        requirement, _, marker = line.partition(";")
        if marker.strip() and not re.search(r"extra\s*==\s*['\"]pipeline['\"]", marker):
            continue
        match = re.match(r"\s*([A-Za-z0-9._-]+)\s*(.*?)\s*$", requirement)
        if match:
            found.append((match[1], match[2].replace(" ", "")))
    return found


def _fits(version: str, wanted: str) -> bool:
    """Whether a version is one that is asked for; yes where that can't be told."""
    try:
        from packaging.specifiers import SpecifierSet
    except ImportError:
        return True
    return SpecifierSet(wanted).contains(version, prereleases=True)


def compiled_modules() -> Iterator[Finding]:
    """Compiled modules, each imported by a process of its own, for one may end its process."""
    started = {
        name: subprocess.Popen(
            [sys.executable, "-c", _PROBE, name],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
            text=True,
        )
        for name in _COMPILED
    }
    for name, process in started.items():
        use, package = _COMPILED[name]
        top = name.partition(".")[0]
        what = f"{top} ({use})"
        try:
            out, said = process.communicate(timeout=_IMPORT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            out, said = "", "does not load within minutes"
        version = re.search(r"^version (.*)$", out, re.MULTILINE)
        if process.returncode == 0 and version:
            yield Finding(what=what, state="ok", found=version[1])
            continue
        why = (said.strip().splitlines() or [f"ends its process ({process.returncode})"])[-1]
        remedy = remedy_for(top, package, why)
        yield Finding(what=what, state="missing", found=why[:200], remedy=remedy)


def remedy_for(name: str, package: str | None, why: str) -> str:
    """The command for a module that can't be imported."""
    for library, own in _LIBRARIES.items():
        if library in why:
            return apt(own)
    if "complex numbers" in why:
        others = "dolfinx-solver dolfinx-solver-complex"
        return f"{sys.executable} -m pip uninstall {others}; {pip(_WHEEL)}"
    if package is None:
        return pip(next((n + v for n, v in _requirements() if n == name), name))
    hidden = Path("/usr/lib/python3/dist-packages", name).exists()
    if hidden and "No module named" in why:
        # installed, but this Python or environment does not look there
        inside = sys.prefix != sys.base_prefix and sys.base_prefix == "/usr"
        folder = f"--upgrade {sys.prefix}" if inside else ".venv"
        return f"/usr/bin/python3 -m venv --system-site-packages {folder}"
    # Debian's packages are for its own Python
    is_other = sys.base_prefix != "/usr" and sys.version_info >= (3, 12)
    return pip(_WHEEL) if is_other else apt(package)


def _compiler() -> Finding:
    compiler = _program(os.environ.get("CC", "gcc"), "cc")
    return _seen("C compiler (element kernels)", compiler, apt("gcc", "g++"), needed=True)


def _form_cache() -> Any:
    """The module of that cache, without the finite elements that its package loads."""
    path = Path(__file__).parents[1] / "reduction" / "operators" / "form_cache.py"
    spec = util.spec_from_file_location("form_cache", path)
    assert spec is not None and spec.loader is not None
    module = util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def kernel_cache() -> Finding:
    """Folder of compiled kernels: without it every run would compile them."""
    what = "cache of compiled kernels"
    folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "fenics"
    form_cache = _form_cache()
    problem = form_cache.cache_problem(folder)
    if problem:
        remedy = f"export XDG_CACHE_HOME=<a folder of yours>  # {folder} can not be written"
        if not (nearest := _nearest(folder)).is_dir():
            remedy = f"rm {shlex.quote(str(nearest))}"
        return Finding(what=what, state="missing", found=problem, remedy=remedy)
    damaged = form_cache.damaged_kernels(folder)
    if damaged:
        found = f"{folder}, {len(damaged)} damaged; runs that need them compile them again"
        remedy = " ".join(["rm -r", *(f"{shlex.quote(str(folder))}/{name}.*" for name in damaged)])
        return _seen(what, found, remedy, good=False, needed=True)
    return _seen(what, str(folder), "", needed=True)


def _nearest(folder: Path) -> Path:
    """The folder, or the nearest one above it that is there."""
    while not folder.exists() and not folder.is_symlink() and folder != folder.parent:
        folder = folder.parent
    return folder


def _memory() -> Finding:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii")
        gib = int(lines.partition("MemAvailable:")[2].split()[0]) / 1024.0**2
    except (OSError, ValueError, IndexError):
        return _seen("memory", "not known", good=False)
    return _seen("memory", f"{gib:.1f} GiB available", good=gib >= _LEAST_MEMORY_GIB)


def _disk() -> Finding:
    """Where stages are kept: the store of several runs, else the folder of each run."""
    given = os.environ.get("SOLIDWHIRL_STORE")
    folder = Path(given) if given else Path.cwd()
    nearest = _nearest(folder)
    what = "store of stages" if given else "this folder"
    if not nearest.is_dir() or not os.access(nearest, os.W_OK | os.X_OK):
        remedy = "unset SOLIDWHIRL_STORE" if given else "cd <a folder of yours>"
        return _seen(what, None, remedy, needed=bool(given))
    gib = shutil.disk_usage(nearest).free / 1024.0**3
    said = f"{folder}, {gib:.1f} GiB free"
    return _seen(what, said, good=gib >= _LEAST_DISK_GIB, needed=bool(given))


def _threads() -> Finding:
    given = os.environ.get("OPENBLAS_NUM_THREADS")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    many = given not in (None, "", "1")
    said = f"{cores} cores, OPENBLAS_NUM_THREADS={given or 1}"
    said += "; more than one costs time and gains none" if many else ""
    return _seen("cores and threads", said, "unset OPENBLAS_NUM_THREADS", good=not many)


def _blas() -> Finding:
    """Debian's reference BLAS makes factorisations 4 to 8 times slower."""
    folder = Path("/usr/lib", sysconfig.get_config_var("MULTIARCH") or "")
    library = (folder / "libblas.so.3").resolve()
    slow = library.is_file() and library.parent.name == "blas"
    said = f"{library}" + (", 4 to 8 times slower than OpenBLAS" if slow else "")
    return _seen("BLAS", said, apt("libopenblas0-pthread"), good=not slow)


def _comforts() -> Iterator[Finding]:
    """Programs and libraries that some commands want."""
    launcher = _program("mpirun", "mpiexec")
    yield _seen("mpirun (several ranks)", launcher, apt("openmpi-bin"))
    what = "libEGL (pictures of solids without a screen)"
    yield _seen(what, ctypes.util.find_library("EGL"), apt("libegl1"))
    try:  # the wheel brings its own; Debian's does as well
        ffmpeg: str | None = f"that of imageio-ffmpeg {metadata.version('imageio-ffmpeg')}"
    except metadata.PackageNotFoundError:
        ffmpeg = _program("ffmpeg")
    yield _seen("ffmpeg (animations as MP4)", ffmpeg, apt("ffmpeg"))
    browser = _program("chromium", "google-chrome", "firefox-esr", "firefox")
    what = "browser (to see report.html here, and for tests)"
    yield _seen(what, browser, apt("chromium", "chromium-driver"))


def _program(*names: str) -> str | None:
    """Path of the first of some programs that is there, of this environment or on the path."""
    places = os.pathsep.join((sysconfig.get_path("scripts"), os.environ.get("PATH", os.defpath)))
    return next((path for name in names if (path := shutil.which(name, path=places))), None)


def _seen(
    what: str, found: str | None, remedy: str = "", *, good: bool = True, needed: bool = False
) -> Finding:
    """What is there or not, and whether it will do well."""
    state: State = "missing" if not found else "ok" if good else "doubtful"
    left = "" if state == "ok" else remedy
    return Finding(what=what, state=state, found=found or "", needed=needed, remedy=left)


def main() -> int:
    """Examine, write what was found, and return the exit code; 2 where it can't be written."""
    found = examine()
    if sys.stdout is None:  # closed
        return exit_code(found)
    try:
        sys.stdout.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]
        sys.stdout.write("\n".join(report_lines(found)) + "\n")
        sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what is left unwritten, at the end
        return exit_code(found) if isinstance(error, BrokenPipeError) else 2
    return exit_code(found)


if __name__ == "__main__":
    sys.exit(main())
