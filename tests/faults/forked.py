"""Runs of the command in forks of a process that has everything imported, so that each is short.

MPI is not imported here: every fork starts its own.
"""

from __future__ import annotations

import json
import os
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

import matplotlib.backends.backend_agg  # noqa: F401
from of_the_run import OF_THE_RUN

import solidwhirl.output.documents
import solidwhirl.rotordyn.plots.errors
import solidwhirl.rotordyn.plots.response  # noqa: F401
from solidwhirl.cache.files import surroundings
from solidwhirl.cli import main
from solidwhirl.files.run_folder import verify_folder

assert "mpi4py.MPI" not in sys.modules
surroundings()  # once: the digest of the program is the same in all forks
_LIMIT_S = 60.0


class Run:
    """A run of the command in a process of its own."""

    def __init__(self, scene, out, *options, before=lambda: None):
        self._log = tempfile.TemporaryFile()  # noqa: SIM115
        self.pid = os.fork()
        if self.pid == 0:
            self._work(["solidwhirl", "run", str(scene), "--out", str(out), *options], before)

    def _work(self, arguments, before):
        """In the fork: never returns."""
        code = 70
        try:
            os.dup2(self._log.fileno(), 1)
            os.dup2(self._log.fileno(), 2)
            sys.argv = arguments
            before()
            main()
        except SystemExit as end:
            code = end.code or 0
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)

    def end(self, limit_s=_LIMIT_S):
        """Wait; the exit code, negative for a signal."""
        start = time.monotonic()
        while True:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                return os.waitstatus_to_exitcode(status)
            if time.monotonic() - start > limit_s:
                os.kill(self.pid, signal.SIGKILL)
            time.sleep(0.002)

    def signal_after(self, seconds, number):
        """Send a signal after some time, then wait."""
        time.sleep(seconds)
        os.kill(self.pid, number)
        return self.end()

    def said(self):
        """What it printed."""
        size = os.fstat(self._log.fileno()).st_size
        return os.pread(self._log.fileno(), size, 0).decode("utf-8", "replace")


def numbers(out):
    """What results.json says but for times and memory; None where there is none."""
    try:
        document = json.loads((Path(out) / "results.json").read_text(encoding="utf-8"))
    except FileNotFoundError:
        return None
    return {key: value for key, value in document.items() if key not in OF_THE_RUN}


def differences(first, second, where=""):
    """Places at which two documents differ, with what they say there."""
    if type(first) is not type(second):
        yield f"{where}: {first!r:.80} and {second!r:.80}"
    elif isinstance(first, dict):
        for key in first.keys() | second.keys():
            yield from differences(first.get(key), second.get(key), f"{where}.{key}")
    elif isinstance(first, list) and len(first) == len(second):
        for k, (a, b) in enumerate(zip(first, second, strict=True)):
            yield from differences(a, b, f"{where}[{k}]")
    elif first != second:
        yield f"{where}: {first!r:.80} and {second!r:.80}"


def stages(out):
    """Where the stages of a run came from."""
    text = (Path(out) / "results.json").read_text(encoding="utf-8")
    return list(json.loads(text)["stages"].values())


def leftovers(out):
    """Temporary files in a folder and its stages."""
    found = [*Path(out).glob(".*"), *Path(out).glob(".stages/.*")]
    return sorted(p.name for p in found if p.name != ".stages")


def problems(out):
    """What is wrong with a folder by its manifest."""
    return verify_folder(out)
