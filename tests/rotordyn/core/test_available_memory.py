"""Memory that a process may take, from what the kernel tells."""

from __future__ import annotations

import subprocess
import sys

import pytest

from solidwhirl.rotordyn.core.available_memory import available_memory

GIB = 1024**3


JOB, OLD = "sys/fs/cgroup/batch/job/memory", "sys/fs/cgroup/memory/job/memory"
GROUP_2, GROUP_1 = "0::/batch/job\n", "9:name=systemd:/\n4:cpu,memory:/job\n"


def _group(told, folder, **values):
    """Files of a control group: what the process is told of it, and its numbers."""
    numbers = {f"{folder}.{name}": f"{value}\n" for name, value in values.items()}
    return {"proc/self/cgroup": told, **numbers}


IN_JOB = _group(
    GROUP_2, JOB, max=3 * GIB, current=2 * GIB, stat=f"anon 5\ninactive_file {GIB // 2}"
)
AROUND = _group(GROUP_2, "sys/fs/cgroup/batch/memory", max=GIB, current=GIB // 4)
KERNELS = {
    "machine alone": ({}, 8 * GIB),
    "control group of version 2": (IN_JOB, 3 * GIB // 2),
    "group around it": (_group(GROUP_2, JOB, max="max", current=1) | AROUND, 3 * GIB // 4),
    "full group": (_group("0::/\n", "sys/fs/cgroup/memory", max=1000, current=2000), 0),
    **{
        f"version 1, limit {limit}": (
            _group(GROUP_1, OLD, limit_in_bytes=limit, usage_in_bytes=GIB),
            left,
        )
        for limit, left in ((2 * GIB, GIB), (9223372036854771712, 8 * GIB))
    },
}


@pytest.mark.parametrize("case", KERNELS)
def test_what_the_kernel_tells(tmp_path, case):
    """With 8 GiB of memory free."""
    files, left = KERNELS[case]
    for name, text in {"proc/meminfo": f"MemAvailable: {8 * GIB // 1024} kB\n", **files}.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    assert available_memory(tmp_path) == left


def test_unknown_machine(tmp_path):
    assert available_memory(tmp_path) is None


def test_limit_of_the_address_space():
    program = (
        "import resource\n"
        "from solidwhirl.rotordyn.core.available_memory import available_memory\n"
        "before = available_memory()\n"
        f"resource.setrlimit(resource.RLIMIT_AS, ({4 * GIB}, {4 * GIB}))\n"
        "print(before, available_memory())\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    before, after = (int(word) for word in done.stdout.split())
    # a fifth is left to libraries; what the interpreter has taken is less than 2 GiB
    assert 0.8 * 2 * GIB < after < min(before, 0.8 * 4 * GIB + 1)
