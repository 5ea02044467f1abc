#!/usr/bin/env bash
# Submits a sequence to Slurm.
set -euo pipefail

usage='usage: submit.sh [options] SCENE FRAMES [options of slo-rt]

Submits the frames of SCENE that are not finished yet to Slurm: an array of jobs of one frame each.
  submit.sh table.txt 1-100 -od output/table
  submit.sh --chunk 10 --sbatch --partition=render table.txt 1-100 -od output/table
  submit.sh --parts 40 table.txt 15 -od output/table --size 15360x8640

All nodes must share the folder under the same path. Running the same command again submits the
missing frames. A job that reaches its time limit keeps the samples of its frame, is queued again,
and continues from there; so does a job whose node dies.

  --chunk N     frames in each job (default: 1); for frames that take less than a minute or so
  --parts N     renders each frame in N jobs, and merges the parts in a job that waits for them
  --slots N     runs at most N jobs at a time
  --sbatch ARG  an argument for sbatch, such as --partition=render or --time=2:00:00; repeatable
  --dry-run     prints the jobs without submitting them

Each job has a node to itself; with --sbatch --cpus-per-task=8 it has 8 processors of a node.
Logs are in the folder `log` of the output folder. The program is $SLO_RT, or slo-rt of this
checkout (target/release), or slo-rt on the PATH.
Prints the numbers of the jobs. Exit code: 0 submitted, or nothing to do; 2 wrong usage, or the
scene has none of the frames; the exit code of slo-rt if the scene has errors; the exit code of
sbatch if it fails.'

fail_usage() {
    printf 'submit.sh: %s; --help says more\n' "$1" >&2
    exit 2
}

is_count() { [[ $1 =~ ^[1-9][0-9]{0,6}$ ]]; }

chunk=1 parts=1 slots='' dry='' sbatch=()
while (($# > 0)); do
    case $1 in
    -h | --help)
        printf '%s\n' "$usage"
        exit 0
        ;;
    --dry-run) dry=1 && shift && continue ;;
    --chunk | --parts | --slots)
        is_count "${2-}" || fail_usage "$1 needs a number from 1 on"
        printf -v "${1#--}" %s "$2"
        ;;
    --sbatch)
        [[ -n ${2-} ]] || fail_usage '--sbatch needs an argument for sbatch'
        sbatch+=("$2")
        ;;
    -*) fail_usage "there is no option $1; options of slo-rt stand at the end" ;;
    *) break ;;
    esac
    shift 2
done
(($# >= 2)) || fail_usage 'SCENE and FRAMES are needed'
scene=$1 frames=$2
shift 2

# Options that the jobs set themselves are removed, because no option may occur twice.
outdir=. threads='' options=()
while (($# > 0)); do
    case $1 in
    -od | --outdir)
        outdir=${2-}
        shift
        ;;
    -od=* | --outdir=*) outdir=${1#*=} ;;
    --threads)
        threads=${2-}
        shift
        ;;
    --threads=*) threads=${1#*=} ;;
    --skip-existing) ;;
    --overwrite) fail_usage 'remove the pictures instead of --overwrite: jobs that go on would begin anew' ;;
    --part | --part=*) fail_usage '--parts N in front of the scene shares frames out, instead of --part' ;;
    --dry-run | --check) fail_usage "$1 stands in front of the scene, or is for slo-rt without Slurm" ;;
    *) options+=("$1") ;;
    esac
    shift $(($# > 0))
done
[[ -n $outdir ]] || fail_usage '--outdir needs a folder'

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
program=${SLO_RT:-$here/../../target/release/slo-rt}
[[ -n ${SLO_RT-} || -x $program ]] || program=slo-rt
program=$(type -P -- "$program") || fail_usage 'there is no slo-rt; $SLO_RT says where it is'

# slo-rt lists the frames to render, and reports errors in the scene here and not on a node.
plan=$("$program" --scene "$scene" --frame="$frames" --outdir "$outdir" \
    ${options[@]+"${options[@]}"} --skip-existing --dry-run)
missing=() pictures=() absent=0
while IFS=$'\t' read -r frame path state; do
    case $state in
    finished) ;;
    'no such frame')
        printf 'submit.sh: the scene has no frame %s\n' "$frame" >&2
        absent=2
        ;;
    *) missing+=("$frame") pictures+=("$path") ;;
    esac
done <<<"$plan"
if ((${#missing[@]} == 0)); then
    ((absent != 0)) || printf 'submit.sh: all frames are finished\n' >&2
    exit "$absent"
fi

# One element for each job of the array: its frames, and with --parts its part.
most=1001
if [[ -z $dry ]]; then
    most=$(scontrol show config | sed -n 's/^MaxArraySize *= *//p')
fi
((parts == 1)) || chunk=1
tasks() { echo $((parts * ((${#missing[@]} + chunk - 1) / chunk))); }
if (($(tasks) > most)); then
    ((parts == 1)) || fail_usage "$(tasks) jobs are too many: this Slurm has arrays of $most"
    chunk=$(((${#missing[@]} + most - 1) / most))
    printf 'submit.sh: %s frames in each job, since this Slurm has arrays of %s\n' "$chunk" "$most" >&2
fi
ranges=() shares=()
for ((i = 0; i < ${#missing[@]}; i += chunk)); do
    range=$(IFS=,; echo "${missing[*]:i:chunk}")
    for ((part = 1; part <= parts; part++)); do
        ranges+=("$range") shares+=("$part/$parts")
    done
done

log=$outdir/log
common=(--parsable --job-name="slo-rt ${scene##*/}" --open-mode=append)
array=0-$((${#ranges[@]} - 1))${slots:+%$slots}
# A job takes its node exclusively unless --cpus-per-task is given.
[[ " ${sbatch[*]-} " == *' --cpus-per-task'* || " ${sbatch[*]-} " == *' -c'* ]] || common+=(--exclusive)
submit() {
    local name=$1
    shift
    # Slurm stores the script, so the job needs no other file of this folder.
    {
        echo '#!/usr/bin/env bash'
        declare -p program scene outdir threads options parts ranges shares missing pictures
        sed 1d "$here/$name"
    } | if [[ -n $dry ]]; then
        {
            printf 'sbatch %s <<END\n' "${*@Q}"
            cat
            printf 'END\n\n'
        } >&2
        echo JOB
    else
        sbatch "$@"
    fi
}

[[ -n $dry ]] || mkdir -p -- "$log"
render=$(submit render.sh "${common[@]}" --array="$array" --output="$log/slurm-%A_%a.log" \
    --requeue --signal=B:USR1@60 ${sbatch[@]+"${sbatch[@]}"})
printf '%s\n' "$render"
if ((parts > 1)); then
    submit merge.sh "${common[@]}" --output="$log/slurm-%j-merge.log" \
        --dependency="afterany:${render%%;*}" ${sbatch[@]+"${sbatch[@]}"}
fi
