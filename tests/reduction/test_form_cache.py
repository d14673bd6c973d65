"""The form compiler's cache among several processes, with a stand-in for the compiler."""

from __future__ import annotations

import multiprocessing
import os
import time
from types import SimpleNamespace

import pytest

from solidwhirl.reduction.operators.form_cache import guard_compiler

SOURCE = "libffcx_forms_0.c"


def compile_forms(forms, *, cache_dir, seconds=0.0, said=None):
    """What FFCx does: claim a source, compile it, and say that it is ready."""
    source = cache_dir / SOURCE
    try:
        source.open("x")  # and leaves it to the collector to close it, which is a warning
    except FileExistsError:
        if not source.with_suffix(".c.cached").exists():
            raise TimeoutError("JIT compilation timed out") from None
        return "found"
    time.sleep(seconds)
    if said == "interrupted":
        raise KeyboardInterrupt
    if said == "killed":
        os._exit(9)
    source.with_suffix(".c.cached").touch()
    return "compiled"


@pytest.fixture
def compiler():
    module = SimpleNamespace(compile_forms=compile_forms)
    guard_compiler(module)
    once = module.compile_forms
    guard_compiler(module)
    assert module.compile_forms is once
    return module.compile_forms


def _compiled(compiler, folder, results):
    results.put(compiler([], cache_dir=folder, seconds=0.5))


def test_processes_that_come_at_once_wait_for_the_first(compiler, tmp_path):
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    jobs = [context.Process(target=_compiled, args=(compiler, tmp_path, results)) for _ in range(4)]
    for job in jobs:
        job.start()
    found = sorted(results.get(timeout=60.0) for _ in jobs)
    for job in jobs:
        job.join(60.0)
    assert found == ["compiled", "found", "found", "found"]


def test_next_one_compiles_what_a_killed_one_began(compiler, tmp_path):
    whole = tmp_path / "libffcx_forms_1.c"
    whole.touch()
    whole.with_suffix(".c.cached").touch()
    context = multiprocessing.get_context("fork")
    options = {"cache_dir": tmp_path, "said": "killed"}
    job = context.Process(target=compiler, args=([],), kwargs=options)
    job.start()
    job.join(60.0)
    assert job.exitcode == 9
    assert compiler([], cache_dir=tmp_path) == "compiled"
    assert whole.exists()


def test_next_one_compiles_what_an_interrupted_one_began(compiler, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        compiler([], cache_dir=tmp_path, said="interrupted")
    assert compiler([], cache_dir=tmp_path) == "compiled"


def test_source_that_another_program_compiles_is_left_alone(compiler, tmp_path):
    (tmp_path / SOURCE).touch()
    with pytest.raises(TimeoutError):
        compiler([], cache_dir=tmp_path)
    assert (tmp_path / SOURCE).exists()
