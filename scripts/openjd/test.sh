#!/usr/bin/env bash
# Runs the job template with PyPI's openjd-cli, and compares its pictures with those of a direct run.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
program=$(realpath -- "${SLO_RT:-target/release/slo-rt}")

lack() {
    printf 'SKIPPED: the test of OpenJD needs %s\n' "$1" >&2
    exit 3
}
[[ -x $program ]] || lack 'slo-rt, built by cargo build --release'

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
openjd=$(type -P openjd) || {
    { python3 -m venv "$folder/venv" && timeout 120 "$folder/venv/bin/pip" install openjd-cli; } \
        >"$folder/log" 2>&1 || lack 'openjd-cli, or Python 3 and PyPI'
    openjd=$folder/venv/bin/openjd
}

template=scripts/openjd/slo-rt.yaml
options='--size 64x36 --samples 8'
parameters=(-p "Folder=$PWD" -p Scene=scenes/default.txt -p Frames=-1-5:3 -p "Program=$program"
    -p "OutDir=$folder/job" -p "Options=$options")
"$openjd" check "$template"
"$openjd" run "$template" --step Render "${parameters[@]}" >"$folder/log" 2>&1 || {
    tail -n 40 "$folder/log"
    exit 1
}
# shellcheck disable=SC2086
"$program" -q --scene scenes/default.txt --frame=-1-5x3 $options --outdir "$folder/local" >"$folder/list"
diff -r "$folder/job" "$folder/local"
grep -q 'openjd_progress: 100' "$folder/log"

# If slo-rt fails, OpenJD reports the task as failed.
if "$openjd" run "$template" --step Render "${parameters[@]}" -p Frames=99 >"$folder/log" 2>&1; then
    echo 'a frame that the scene does not have is said to be rendered'
    exit 1
fi
printf '%s frames by OpenJD, byte for byte equal to a direct run\n' "$(wc -l <"$folder/list")"
