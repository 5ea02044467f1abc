#!/usr/bin/env bash
# Renders a sequence with GNU parallel, on hosts that ssh reaches or in several processes on this machine.
set -euo pipefail

usage='usage: parallel.sh [options] SCENE FRAMES [options of slo-rt]

Renders the frames of SCENE that are not finished yet, each in a run of slo-rt.
  parallel.sh --hosts anna,bert,: table.txt 1-100 -od output/table
  parallel.sh --jobs 2 table.txt 1-100 -od output/table --threads 4

The hosts must share this folder under the same path, and ssh must reach them without a password.
Running the same command again renders the missing frames. If a host or its connection dies, its
frame is tried on another host, and continues from its last checkpoint.

  --hosts HOSTS   hosts separated by commas, `:` for this machine (default: `:`)
  --jobs N        frames at a time on each host (default: 1; slo-rt uses all processors for a frame)
  --retries N     number of tries for each frame (default: 3)

The program is $SLO_RT, or slo-rt of this checkout (target/release), or slo-rt on the PATH; hosts
use the same path. Prints the paths of the pictures. Exit code: 0 all frames are finished; 1 to 100
the number of frames that failed; 101 more frames failed; 2 wrong usage, too; the exit code of
slo-rt if the scene has errors.'

fail_usage() {
    printf 'parallel.sh: %s; --help says more\n' "$1" >&2
    exit 2
}

hosts=: jobs=1 retries=3
while (($# > 0)); do
    case $1 in
    -h | --help)
        printf '%s\n' "$usage"
        exit 0
        ;;
    --hosts) hosts=${2:?"--hosts needs hosts"} ;;
    --jobs | --retries)
        [[ ${2-} =~ ^[1-9][0-9]{0,5}$ ]] || fail_usage "$1 needs a number from 1 on"
        printf -v "${1#--}" %s "$2"
        ;;
    -*) fail_usage "there is no option $1; options of slo-rt stand at the end" ;;
    *) break ;;
    esac
    shift 2
done
(($# >= 2)) || fail_usage 'SCENE and FRAMES are needed'
scene=$1 frames=$2
shift 2
parallel --version 2>/dev/null | grep -q '^GNU' || fail_usage 'GNU parallel is needed (Debian: parallel)'

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
program=${SLO_RT:-$here/../target/release/slo-rt}
[[ -n ${SLO_RT-} || -x $program ]] || program=slo-rt
program=$(type -P -- "$program") || fail_usage 'there is no slo-rt; $SLO_RT says where it is'

run=("$(realpath -- "$program")" --scene "$scene" --skip-existing "$@")
[[ " $* " == *' --progress'* ]] || run+=(--progress none)
plan=$("${run[@]}" --frame="$frames" --dry-run)
# If the scene has errors, slo-rt has reported them by now, here and not on a host. Each missing frame is a task.
missing=$(awk -F '\t' '$3 != "finished" { print $1 }' <<<"$plan")
if [[ -z $missing ]]; then
    printf 'parallel.sh: all frames are finished\n' >&2
    exit 0
fi
# TERM first, so that unfinished frames keep their samples when this script is stopped.
parallel --will-cite --sshlogin "$hosts" --workdir "$PWD" --jobs "$jobs" --retries "$retries" \
    --line-buffer --termseq TERM,10000,KILL,25 "${run[@]@Q}" --frame={} <<<"$missing"
