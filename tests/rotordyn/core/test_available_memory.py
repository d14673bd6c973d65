"""Memory that a process may take, from what the kernel tells."""

from __future__ import annotations

import subprocess
import sys

import pytest

from solidwhirl.rotordyn.core.available_memory import available_memory

GIB = 1024**3


@pytest.fixture
def kernel(tmp_path):
    """Function: write files of a kernel below a folder, 8 GiB of memory being free."""

    def write(files):
        for name, text in {
            "proc/meminfo": f"MemAvailable: {8 * GIB // 1024} kB\n",
            **files,
        }.items():
            path = tmp_path / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        return tmp_path

    return write


def test_machine_alone(kernel):
    assert available_memory(kernel({})) == 8 * GIB


def test_unknown_machine(tmp_path):
    assert available_memory(tmp_path) is None


def test_control_group_of_version_2(kernel):
    root = kernel(
        {
            "proc/self/cgroup": "0::/batch/job\n",
            "sys/fs/cgroup/batch/job/memory.max": f"{3 * GIB}\n",
            "sys/fs/cgroup/batch/job/memory.current": f"{2 * GIB}\n",
            "sys/fs/cgroup/batch/job/memory.stat": f"anon 5\ninactive_file {GIB // 2}\n",
        }
    )
    assert available_memory(root) == 3 * GIB // 2


def test_group_around_it_limits_too(kernel):
    root = kernel(
        {
            "proc/self/cgroup": "0::/batch/job\n",
            "sys/fs/cgroup/batch/job/memory.max": "max\n",
            "sys/fs/cgroup/batch/job/memory.current": "1\n",
            "sys/fs/cgroup/batch/memory.max": f"{GIB}\n",
            "sys/fs/cgroup/batch/memory.current": f"{GIB // 4}\n",
        }
    )
    assert available_memory(root) == 3 * GIB // 4


@pytest.mark.parametrize(("limit", "left"), [(2 * GIB, GIB), (9223372036854771712, 8 * GIB)])
def test_control_group_of_version_1(kernel, limit, left):
    root = kernel(
        {
            "proc/self/cgroup": "9:name=systemd:/\n4:cpu,memory:/job\n",
            "sys/fs/cgroup/memory/job/memory.limit_in_bytes": f"{limit}\n",
            "sys/fs/cgroup/memory/job/memory.usage_in_bytes": f"{GIB}\n",
        }
    )
    assert available_memory(root) == left


def test_group_that_is_full(kernel):
    root = kernel(
        {
            "proc/self/cgroup": "0::/\n",
            "sys/fs/cgroup/memory.max": "1000\n",
            "sys/fs/cgroup/memory.current": "2000\n",
        }
    )
    assert available_memory(root) == 0


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
