#!/usr/bin/env bash
# The job that merges the parts. submit.sh submits it and puts the variables in front.
# shellcheck disable=SC2154

failed=0
for picture in "${pictures[@]}"; do
    name=${picture##*/}
    files=("$outdir/parts/${name%.*}".*-of-"$parts".part)
    if "$program" merge "${files[@]}" --outdir "$outdir"; then
        rm -f -- "${files[@]}"
    else
        failed=$?
    fi
done
rmdir -- "$outdir/parts" 2>/dev/null
exit "$failed"
