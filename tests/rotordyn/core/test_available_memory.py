"""Memory that a process may take, from what the kernel tells."""

from __future__ import annotations

import subprocess
import sys

import pytest

from solidwhirl.rotordyn.core.available_memory import available_memory

GIB = 1024**3


JOB, OLD = "sys/fs/cgroup/batch/job/memory", "sys/fs/cgroup/memory/job/memory"
GROUP_2, GROUP_1 = "0::/batch/job\n", "9:name=systemd:/\n4:cpu,memory:/job\n"
KERNELS = {
    "machine alone": ({}, 8 * GIB),
    "control group of version 2": (
        {
            "proc/self/cgroup": GROUP_2,
            f"{JOB}.max": f"{3 * GIB}\n",
            f"{JOB}.current": f"{2 * GIB}\n",
            f"{JOB}.stat": f"anon 5\ninactive_file {GIB // 2}\n",
        },
        3 * GIB // 2,
    ),
    "group around it": (
        {
            "proc/self/cgroup": GROUP_2,
            f"{JOB}.max": "max\n",
            f"{JOB}.current": "1\n",
            "sys/fs/cgroup/batch/memory.max": f"{GIB}\n",
            "sys/fs/cgroup/batch/memory.current": f"{GIB // 4}\n",
        },
        3 * GIB // 4,
    ),
    "full group": (
        {
            "proc/self/cgroup": "0::/\n",
            "sys/fs/cgroup/memory.max": "1000\n",
            "sys/fs/cgroup/memory.current": "2000\n",
        },
        0,
    ),
    **{
        f"version 1, limit {limit}": (
            {
                "proc/self/cgroup": GROUP_1,
                f"{OLD}.limit_in_bytes": f"{limit}\n",
                f"{OLD}.usage_in_bytes": f"{GIB}\n",
            },
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
