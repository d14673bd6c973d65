"""A Slurm script for a batch, which goes on after preemption and asks for what is forecast."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from jinja2 import Template

from solidwhirl.batch.schedule import Predicted
from solidwhirl.core.errors import UserError, one_line, writing
from solidwhirl.files.run_folder import refuse_foreign
from solidwhirl.rotordyn.core.atomic import replacing

# A job is asked for so long, if cases are many [s]; teams are as many as that takes.
_AIM_S = 3600.0
# What forecasts may be wrong by, and what starting and analyses take [s].
_TIME_RESERVE, _START_S = 2.0, 900.0
_MEMORY_RESERVE = 1.25
_LEAST_MIB, _MIB = 1024, 1024.0
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
    template = (resources.files(__package__) / "slurm.sh").read_text(encoding="utf-8")
    text: str = Template(template, keep_trailing_newline=True).render(
        job=job,
        time=_time_text(job.minutes),
        # % begins a pattern of Slurm's in names of files
        log=_quoted(str(job.log).replace("%", "%%")),
        folder=shlex.quote(str(Path.cwd())),
        command=shlex.join(job.command),
        whole=_WHOLE,
    )
    return text


def write_slurm_script(job: SlurmJob, path: Path) -> Path:
    """Write the script; it can be started as it is.

    Raises UserError: a line break in a path, which no line for Slurm can hold.
    """
    for name in (str(job.log), str(Path.cwd())):
        if not name.isprintable():
            raise UserError(f"{one_line(name)}: a path in a script for Slurm has no line breaks")
    refuse_foreign(path, _WHOLE, "is no script of a batch; move it away")
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
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
