"""A Slurm script for a batch, which goes on after preemption and asks for what is forecast."""

from __future__ import annotations

import math
import os
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from solidwhirl.batch.schedule import Predicted
from solidwhirl.core.errors import OutputError
from solidwhirl.rotordyn.core.atomic import replacing

# A job is asked for so long, if cases are many [s]; teams are as many as that takes.
_AIM_S = 3600.0
# What forecasts may be wrong by, and what starting and analyses take [s].
_TIME_RESERVE, _START_S = 2.0, 900.0
_MEMORY_RESERVE = 1.25
_LEAST_MIB, _MIB = 1024, 1024.0
_SIGNAL_S = 120
# mpirun waits so long before it passes SIGTERM on, and again before SIGKILL [s].
_PATIENCE_S = 10
_RESTARTS = 50
# Words of a comment by which a script is known.
_WHOLE = "The ranks get SIGTERM and leave rows and stages whole."
_NAME = re.compile(r"[^A-Za-z0-9_.-]+")


@dataclass(frozen=True, kw_only=True)
class SlurmJob:
    """What is asked of Slurm."""

    name: str  # of the job
    ranks: int  # number of tasks
    memory_mib: int  # memory of each [MiB]
    minutes: int  # time limit [min]
    command: Sequence[str]  # the batch, without mpirun
    log: Path  # file for what it says


def slurm_job(
    costs: Mapping[int, Predicted],
    *,
    command: Sequence[str],
    out: Path,
    ranks_per_scene: int,
    ranks: int | None,
) -> SlurmJob:
    """Choose ranks, memory and time of a job from the forecast.

    As many teams as finish within about an hour, but not more than there are cases, and none that
    would only wait for the largest one.

    `costs`: predicted cost by case, not empty. `command`: the batch, without mpirun. `out`: folder
    of the batch. `ranks_per_scene`: size of a team. `ranks`: number of ranks, if it is chosen
    already.
    """
    total = sum(cost.seconds for cost in costs.values())
    largest = max((cost.seconds for cost in costs.values()), default=0.0)
    peak = max((cost.peak_memory_gib for cost in costs.values()), default=0.0)
    teams = min(len(costs), math.ceil(total / max(largest, _AIM_S))) or 1
    if ranks is not None:
        teams = max(ranks // ranks_per_scene, 1)
    # speed-up of the ranks of a team is not counted on
    longest = _TIME_RESERVE * (total / teams + largest) + _START_S
    share = peak / ranks_per_scene
    memory = math.ceil(_MEMORY_RESERVE * share * _MIB / 256.0) * 256
    return SlurmJob(
        name=_NAME.sub("-", f"solidwhirl-{out.resolve().name}")[:64],
        ranks=ranks or teams * ranks_per_scene,
        memory_mib=max(memory, _LEAST_MIB),
        minutes=math.ceil(longest / 60.0),
        command=command,
        log=out.resolve().with_name(f"{out.resolve().name}.slurm.log"),
    )


def slurm_script(job: SlurmJob) -> str:
    """Return the script."""
    command = shlex.join(job.command)
    # % begins a pattern of Slurm's in names of files
    log = str(job.log).replace("%", "%%")
    return f"""#!/bin/bash
#SBATCH --job-name={job.name}
#SBATCH --ntasks={job.ranks}
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu={job.memory_mib}M
#SBATCH --time={_time_text(job.minutes)}
#SBATCH --output={_quoted(log)}
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:USR1@{_SIGNAL_S}
# To be filled in for the cluster:
##SBATCH --account=ACCOUNT
##SBATCH --partition=PARTITION

set -u
# module purge
# module load openmpi petsc slepc
# source /path/to/.venv/bin/activate

export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
export OMPI_MCA_odls_base_sigkill_timeout={_PATIENCE_S}
cd {shlex.quote(str(Path.cwd()))} || exit 2

launch=(srun --kill-on-bad-exit=1)
# Where srun starts no MPI ranks (each says it is alone):
# launch=(mpirun -n "$SLURM_NTASKS")

# Slurm sends this shell SIGUSR1 {_SIGNAL_S} s before the time limit, and SIGTERM when the job is
# cancelled (srun's ranks as well). {_WHOLE}
job='' limit=0
end() {{ [ -z "$job" ] || kill -TERM "$job" 2>/dev/null; }}
trap 'limit=1; end' USR1
trap '[ "${{launch[0]}}" = srun ] || end' TERM

# What is there is kept, so the same script goes on after a requeue.
"${{launch[@]}}" {command} &
job=$!
[ "$limit" -eq 0 ] || end
wait "$job"
while kill -0 "$job" 2>/dev/null; do wait "$job"; done # a signal ends a wait, not the job
wait "$job"
status=$?

if [ "$limit" -eq 1 ] && [ "$status" -ne 0 ] && [ "${{SLURM_RESTART_COUNT:-0}}" -lt {_RESTARTS} ]
then
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$status"
"""


def _is_script(path: Path) -> bool:
    try:
        return path.is_file() and _WHOLE in path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return False


def write_slurm_script(job: SlurmJob, path: Path) -> Path:
    """Write the script; it can be started as it is."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if os.path.lexists(path) and not _is_script(path):
        raise OutputError(f"{path}: is there already and is no script of a batch; move it away")
    with replacing(path) as temporary:
        temporary.write_text(slurm_script(job), encoding="utf-8")
        temporary.chmod(0o755)
    return path


def _time_text(minutes: int) -> str:
    """Days-hours:minutes:seconds."""
    days, rest = divmod(minutes, 1440)
    hours, left = divmod(rest, 60)
    return f"{days}-{hours:02d}:{left:02d}:00" if days else f"{hours:02d}:{left:02d}:00"


def _quoted(text: str) -> str:
    """A value of an #SBATCH line: quoted where Slurm would split it."""
    if re.fullmatch(r"[\w@%+=:,./-]+", text):
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
