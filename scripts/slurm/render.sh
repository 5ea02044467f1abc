#!/usr/bin/env bash
# A job of an array. submit.sh submits it and puts the variables in front.
# shellcheck disable=SC2154

range=${ranges[SLURM_ARRAY_TASK_ID]}
arguments=(--scene "$scene" --frame="$range" "${options[@]}" --skip-existing)
arguments+=(--threads "${threads:-${SLURM_CPUS_ON_NODE:-1}}")
if ((parts > 1)); then
    arguments+=(--outdir "$outdir/parts" --part "${shares[SLURM_ARRAY_TASK_ID]}")
else
    arguments+=(--outdir "$outdir")
fi
printf 'frame %s on %s, run %s\n' "$range" "${SLURMD_NODENAME-}" "$((${SLURM_RESTART_COUNT:-0} + 1))" >&2

# Slurm announces the time limit by USR1, to this script only. TERM is sent to all processes of the job.
heard='' ended=''
trap 'heard=1; kill -USR1 "$child"' USR1
trap 'heard=1 ended=1' TERM
"$program" "${arguments[@]}" &
child=$!
code=127
while :; do
    heard=''
    wait "$child"
    status=$?
    # 127: the child had ended before this wait.
    ((status == 127)) || code=$status
    [[ -n $heard ]] || break
done

# Whoever ended the job wants it gone, or will queue it again.
if ((code == 75)) && [[ -z $ended ]]; then
    # If the limit is too short even to load the scene, requeueing would never end.
    if ((${SLURM_RESTART_COUNT:-0} < 100)); then
        echo 'queued again, to go on from there' >&2
        scontrol requeue "$SLURM_JOB_ID"
    else
        echo 'stopped a hundred times: the time limit is too short' >&2
    fi
fi
exit "$code"
