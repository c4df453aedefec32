#!/usr/bin/env bash
#SBATCH --job-name=keepout
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --time=24:00:00
#SBATCH --output=%x-%A-%a.log
# One shard of a campaign as a task of a Slurm array. Submit it at the root of a built clone:
#
#   sbatch --array=1-64 campaigns/slurm.sh 64 target/release/hostile --seed 1 --drawings 64000
#   sbatch --array=7 campaigns/slurm.sh 64 target/release/hostile --seed 1 --drawings 64000    # shard 7 again
#
# The first argument is the number of shards, the others are the command. RESULTS names the folder of the results
# files, by default results/.
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: sbatch --array=1-N campaigns/slurm.sh N PROGRAM [ARGUMENT...]" >&2; exit 2; }
: "${SLURM_ARRAY_TASK_ID:?is not set. Submit the script with sbatch --array=1-N}"
shards="$1"
shift
exec "$@" --shard "$SLURM_ARRAY_TASK_ID/$shards" --results "${RESULTS:-results}/$SLURM_ARRAY_TASK_ID.tsv"
