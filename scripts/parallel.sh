#!/usr/bin/env bash
# Renders a sequence by GNU parallel, on hosts that ssh reaches or in several processes here.
set -euo pipefail

usage='usage: parallel.sh [options] SCENE FRAMES [options of slo-rt]

Renders the frames of SCENE that are not finished yet, a run of slo-rt for each.
  parallel.sh --hosts anna,bert,: table.txt 1-100 -od output/table
  parallel.sh --jobs 2 table.txt 1-100 -od output/table --threads 4

The hosts share this folder under the same path, and ssh reaches them without a password. The same
command again renders what is missing; a frame whose host or connection dies is tried on another
host, and goes on from its last checkpoint.

  --hosts HOSTS   hosts between commas, `:` for this machine (:)
  --jobs N        frames at a time on each host (1: slo-rt uses all processors for one frame)
  --retries N     how often a frame is tried (3)

The program is $SLO_RT, or slo-rt of this checkout (target/release), or slo-rt of the path; on hosts,
the same path. Prints the paths of the pictures. Exit code: 0 all frames are there; 1 to 100 so many
frames failed, 101 more of them; 2 wrong usage, too; that of slo-rt where the scene has errors.'

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
# A mistake in the scene has shown by now, here and not on a host; what is missing is one task each.
missing=$(awk -F '\t' '$3 != "finished" { print $1 }' <<<"$plan")
if [[ -z $missing ]]; then
    printf 'parallel.sh: all frames are finished\n' >&2
    exit 0
fi
# TERM first, so that frames are kept when this script is stopped.
parallel --will-cite --sshlogin "$hosts" --workdir "$PWD" --jobs "$jobs" --retries "$retries" \
    --line-buffer --termseq TERM,10000,KILL,25 "${run[@]@Q}" --frame={} <<<"$missing"
