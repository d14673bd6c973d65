#!/bin/bash
#SBATCH --job-name={{ job.name }}
#SBATCH --ntasks={{ job.ranks }}
#SBATCH --cpus-per-task=1
#SBATCH --mem-per-cpu={{ job.memory_mib }}M
#SBATCH --time={{ time }}
#SBATCH --output={{ log }}
#SBATCH --open-mode=append
#SBATCH --requeue
#SBATCH --signal=B:USR1@120
# To be filled in for the cluster:
##SBATCH --account=ACCOUNT
##SBATCH --partition=PARTITION

set -u
# module purge
# module load openmpi petsc slepc
# source /path/to/.venv/bin/activate

export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
# mpirun waits so long before it passes SIGTERM on, and again before SIGKILL [s]
export OMPI_MCA_odls_base_sigkill_timeout=10
cd {{ folder }} || exit 2

launch=(srun --kill-on-bad-exit=1)
# Where srun starts no MPI ranks (each says it is alone):
# launch=(mpirun -n "$SLURM_NTASKS")

# Slurm sends this shell SIGUSR1 120 s before the time limit, and SIGTERM when the job is
# cancelled (srun's ranks as well). {{ whole }}
job='' limit=0
end() { [ -z "$job" ] || kill -TERM "$job" 2>/dev/null; }
trap 'limit=1; end' USR1
trap '[ "${launch[0]}" = srun ] || end' TERM

# What is there is kept, so the same script goes on after a requeue.
"${launch[@]}" {{ command }} &
job=$!
[ "$limit" -eq 0 ] || end
wait "$job"
while kill -0 "$job" 2>/dev/null; do wait "$job"; done # a signal ends a wait, not the job
wait "$job"
status=$?

if [ "$limit" -eq 1 ] && [ "$status" -ne 0 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 50 ]
then
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$status"
