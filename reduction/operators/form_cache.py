"""The form compiler's cache, for several processes at once, after killed ones, and damaged.

FFCx lets a process that finds a form being compiled wait for 10 s, and then raises; of one that was
killed while it compiled, everyone after it waits for ever in vain. What it finds compiled it loads,
whatever has become of it. Damaged kernels are removed here and compiled again.

The standard library alone: `doctor` loads this file by itself.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import hashlib
import logging
import os
import shutil
import struct
import time
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

_LOCK, _MARK = ".solidwhirl.lock", ".solidwhirl.compiling"
_COMPILERS = ("compile_forms", "compile_elements", "compile_coordinate_maps", "compile_expressions")
# The checksum of a kernel that was compiled here, beside it.
_SUM = ".sha256"
# Time after the last change of its files at which a kernel is no longer being compiled [s].
_PATIENCE_S = 30.0
_ELF = b"\x7fELF"


def guard_compiler(module: Any) -> None:
    """Let one process at a time compile into a cache, and remove what is damaged there.

    `module`: `ffcx.codegeneration.jit`; its functions that compile are replaced, once.
    """
    for name in _COMPILERS:
        found = getattr(module, name, None)
        if found is not None and not hasattr(found, "__wrapped__"):
            setattr(module, name, _guarded(found))
    for name, guard in (("get_cached_module", _checking), ("_load_objects", _summing)):
        found = getattr(module, name, None)
        if found is not None and not hasattr(found, "__wrapped__"):
            setattr(module, name, guard(found))


def damaged_kernels(cache: Path) -> tuple[str, ...]:
    """Return the names of kernels in a cache that can't be loaded."""
    names = sorted({path.name.partition(".")[0] for path in cache.glob("libffcx_*")})
    return tuple(name for name in names if _problem(cache, name) and not _compiling(cache, name))


def _files(cache: Path, name: str) -> list[Path]:
    return list(cache.glob(f"{name}.*"))


def _problem(cache: Path, name: str) -> str:
    """What is wrong with the files of a kernel; empty if nothing is, or there are none."""
    source = cache / f"{name}.c"
    libraries = list(cache.glob(f"{name}.*.so"))
    left = [path for path in _files(cache, name) if not path.name.endswith(".c.failed")]
    if not left:
        return ""
    if not (source.is_file() and source.with_suffix(".c.cached").is_file() and libraries):
        return "incomplete"
    try:
        return "" if all(map(_is_whole, libraries)) else "damaged"
    except OSError:
        return "can not be read"


def _is_whole(library: Path) -> bool:
    """Whether a shared library is as it was compiled; of foreign ones, whether its end is there."""
    content = library.read_bytes()
    with contextlib.suppress(FileNotFoundError):
        told = library.with_name(library.name + _SUM).read_text(encoding="ascii", errors="replace")
        return told.strip() == hashlib.sha256(content).hexdigest()
    own = f"PyInit_{library.name.partition('.')[0]}".encode()
    if content[:4] != _ELF or own not in content:
        return False  # a wrong one can't be loaded again by the same process once it was
    if content[4:6] != b"\x02\x01":  # of another kind than 64 bit, low byte first
        return True
    if len(content) < 64:
        return False
    # the table of sections ends the file
    start, size, count = struct.unpack("<Q10xHH", content[40:62])
    return bool(start + size * count <= len(content))


def _compiling(cache: Path, name: str) -> bool:
    """Whether another program may be compiling a kernel now."""
    if (cache / f"{name}.c.cached").exists() or not (cache / f"{name}.c").exists():
        return False
    newest = max((path.stat().st_mtime for path in _files(cache, name)), default=0.0)
    return 0.0 <= time.time() - newest < _PATIENCE_S


def _discard(cache: Path, name: str) -> None:
    """Remove all files of a kernel."""
    for path in _files(cache, name):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)


def _checking(find: Callable[..., Any]) -> Callable[..., Any]:
    """Let the search for a compiled kernel find whole ones alone, and look at each once."""
    known: dict[tuple[str, ...], Any] = {}

    @functools.wraps(find)
    def found(name: str, objects: Any, cache_dir: Any, timeout: int) -> Any:
        key = (str(cache_dir), name, *objects)
        kernel = known.get(key) or whole(name, objects, Path(cache_dir), timeout)
        if kernel[0] is not None:
            known[key] = kernel
        return kernel

    def whole(name: str, objects: Any, cache: Path, timeout: int) -> Any:
        while _compiling(cache, name):
            time.sleep(0.2)
        if _problem(cache, name):
            _discard(cache, name)
        try:
            return find(name, objects, cache, timeout)
        except (ImportError, AttributeError, TimeoutError):
            # whole, but for another Python, or with other content than its name says
            _discard(cache, name)
            return find(name, objects, cache, timeout)

    return found


def _summing(load: Callable[..., Any]) -> Callable[..., Any]:
    """Let the first load of a kernel, after it was compiled, leave its checksum."""

    @functools.wraps(load)
    def loaded(cache_dir: Any, name: str, objects: Any) -> Any:
        found = load(cache_dir, name, objects)
        for library in Path(cache_dir).glob(f"{name}.*.so"):
            digest = hashlib.sha256(library.read_bytes()).hexdigest()
            library.with_name(library.name + _SUM).write_text(digest + "\n", encoding="ascii")
        return found

    return loaded


def _guarded(compiler: Callable[..., Any]) -> Callable[..., Any]:
    # local to a rank: the lock is never held while other ranks are waited for
    @functools.wraps(compiler)
    def compiled(*args: Any, **options: Any) -> Any:
        cache = options.get("cache_dir")
        if cache is None:
            return compiler(*args, **options)
        cache = Path(cache)
        try:
            with _alone(cache), silent():
                return compiler(*args, **options)
        except OSError as error:
            if isinstance(error, TimeoutError):
                raise
            from solidwhirl.reduction.errors import KernelCacheError

            raise KernelCacheError(cache_problem(cache) or f"{cache}: {error}") from error

    return compiled


@contextlib.contextmanager
def silent() -> Iterator[None]:
    """Keep the commands, the progress and open files of the compilers out of the error stream."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ResourceWarning)
            yield
    finally:
        logging.disable(before)


def cache_problem(cache: Path) -> str:
    """Say why no kernel can be compiled into a folder, and what to do; empty if one can."""
    nearest = next(path for path in (cache, *cache.parents) if path.exists() or path.is_symlink())
    if not nearest.is_dir():
        what = "a link to nothing" if nearest.is_symlink() else "not a folder"
        return f"{nearest} is {what}, kernels can not be compiled into {cache}; remove it"
    if not os.access(nearest, os.W_OK | os.X_OK):
        return (
            f"{nearest} can not be written, kernels can not be compiled into {cache}; set "
            "XDG_CACHE_HOME to a folder of yours"
        )
    return ""


@contextlib.contextmanager
def _alone(cache: Path) -> Iterator[None]:
    """Have a cache for this process; where there are no locks, go on without."""
    mark = cache / _MARK
    with contextlib.ExitStack() as held:
        try:
            cache.mkdir(parents=True, exist_ok=True)
            lock = held.enter_context((cache / _LOCK).open("a"))
            fcntl.flock(lock, fcntl.LOCK_EX)
            _clear(cache, mark)
            mark.touch()
        except OSError:
            yield
            return
        try:
            yield
        except Exception:  # the compiler has put its file aside
            mark.unlink(missing_ok=True)
            raise
        # after SIGTERM or Ctrl-C the mark stays, as after SIGKILL
        mark.unlink(missing_ok=True)


def _clear(cache: Path, mark: Path) -> None:
    """Remove sources that a process began to compile and never finished."""
    if not mark.exists():
        return
    since = mark.stat().st_mtime
    for source in cache.glob("libffcx_*.c"):
        if source.with_suffix(".c.cached").exists() or source.stat().st_mtime < since:
            continue
        source.unlink(missing_ok=True)
    mark.unlink()
