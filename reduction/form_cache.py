"""The form compiler's cache, for several processes at once and after killed ones.

FFCx lets a process that finds a form being compiled wait for 10 s, and then raises; of one that was
killed while it compiled, everyone after it waits for ever in vain.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

_LOCK, _MARK = ".solidwhirl.lock", ".solidwhirl.compiling"
_COMPILERS = ("compile_forms", "compile_elements", "compile_coordinate_maps", "compile_expressions")


def guard_compiler(module: Any) -> None:
    """Let one process at a time compile into a cache, and clear what a killed one left there.

    Parameters
    ----------
    module
        `ffcx.codegeneration.jit`; its functions that compile are replaced, once.
    """
    for name in _COMPILERS:
        found = getattr(module, name, None)
        if found is not None and not hasattr(found, "__wrapped__"):
            setattr(module, name, _guarded(found))


def _guarded(compiler: Callable[..., Any]) -> Callable[..., Any]:
    # local to a rank: the lock is never held while other ranks are waited for
    @functools.wraps(compiler)
    def compiled(*args: Any, **options: Any) -> Any:
        cache = options.get("cache_dir")
        if cache is None:
            return compiler(*args, **options)
        with _alone(Path(cache)):
            return compiler(*args, **options)

    return compiled


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
