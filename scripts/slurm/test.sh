#!/usr/bin/env bash
# Renders on a Slurm cluster of two nodes, both on this machine, and kills one of them in the middle of a frame.
set -euo pipefail

usage='usage: test.sh [--install]

Starts munged, slurmctld and two slurmd with their own configuration in a temporary folder, renders
a short sequence by submit.sh, kills a node in the middle of a frame, and compares all pictures with
a local run. Then it renders a frame in parts and stops one part as a time limit does.
Needs root, and Debian'\''s slurm-wlm and munge; --install installs them with apt-get.
The program is $SLO_RT, or slo-rt of this checkout (target/release).
Exit code: 0 passed; 1 failed; 2 wrong usage; 3 a requirement is missing.'

case ${1-} in
'' | --install) ;;
-h | --help) printf '%s\n' "$usage" && exit 0 ;;
*) printf '%s\n' "$usage" >&2 && exit 2 ;;
esac
lack() {
    printf 'SKIPPED: the test of Slurm needs %s\n' "$1" >&2
    exit 3
}
((EUID == 0)) || lack root
needed() { type -P munged slurmctld slurmd sbatch >/dev/null; }
if ! needed && [[ ${1-} == --install ]]; then
    export DEBIAN_FRONTEND=noninteractive RUNLEVEL=1
    packages=(slurm-wlm munge)
    timeout 120 sh -c 'apt-get update && apt-get install -y --no-install-recommends "$@"' - "${packages[@]}" \
        >/dev/null 2>&1 || lack "apt-get that can install ${packages[*]} within two minutes"
fi
needed || lack 'slurm-wlm and munge, which --install installs'

here=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")" && pwd)
SLO_RT=$(realpath -- "${SLO_RT:-$here/../../target/release/slo-rt}")
export SLO_RT
[[ -x $SLO_RT ]] || lack 'slo-rt, built by cargo build --release'
cd -- "$here/../.."
scene=scenes/default.txt

folder=$(mktemp -d)
chmod 755 "$folder"
export SLURM_CONF=$folder/slurm.conf
# All processes started by this test, and no others, have its configuration in their environment.
processes() { grep -lzFx "SLURM_CONF=$SLURM_CONF" /proc/[0-9]*/environ 2>/dev/null | cut -d / -f 3; }
finish() {
    local code=$? pids
    trap - EXIT
    if ((code != 0)); then
        tail -n 20 "$folder"/*.log "$folder"/*/log/* >&2 || true
    fi
    # More than one round, since nodes kill jobs and the controller starts new ones.
    for _ in 1 2 3; do
        mapfile -t pids < <(processes)
        kill -KILL "${pids[@]}" 2>/dev/null || true
    done
    rm -rf "$folder"
    exit "$code"
}
trap finish EXIT
fail() {
    printf 'test.sh: %s\n' "$1" >&2
    exit 1
}
say() { printf '%3ds %s\n' "$SECONDS" "$1"; }
await() {
    local seconds=$1 what=$2
    shift 2
    local end=$((SECONDS + seconds))
    until "$@" >/dev/null 2>&1; do
        ((SECONDS < end)) || fail "waited ${seconds} s for $what"
        sleep 0.2
    done
}

port=$((20000 + RANDOM % 20000))
host=$(hostname -s)
cat >"$SLURM_CONF" <<END
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket,cred_expire=5
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/%n.spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/%n.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/%n.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/linear
MpiDefault=none
ReturnToService=2
SlurmdTimeout=6
KillWait=5
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 1)) CPUs=1
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$((port + 2)) CPUs=1
PartitionName=all Nodes=n1,n2 Default=YES MaxTime=INFINITE State=UP
END
# Versions before 23.02 reject `disabled`, but use no cgroups with proctrack/linuxproc.
IFS=' .' read -r _ major minor _ < <(sbatch --version)
if ((10#$major * 100 + 10#$minor >= 2302)); then cgroup=disabled; else cgroup=cgroup/v1; fi
echo "CgroupPlugin=$cgroup" >"$folder/cgroup.conf"
mkdir "$folder/state" "$folder/n1.spool" "$folder/n2.spool"

(umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
start() {
    "$@" >/dev/null 2>&1 &
    disown
}
start munged --force --foreground --socket="$folder/munge.socket" --key-file="$folder/munge.key" \
    --pid-file="$folder/munge.pid" --log-file="$folder/munge.log" --seed-file="$folder/munge.seed"
await 60 munged munge -n -S "$folder/munge.socket"
start slurmctld -D -i
await 60 slurmctld scontrol ping
start slurmd -D -N n1
node=$!
start slurmd -D -N n2
idle() { [[ $(sinfo -h -n "$1" -o %T) == idle ]]; }
await 60 'node n1' idle n1
await 60 'node n2' idle n2
say 'two nodes are there'

# A frame is killed in its middle, so it must take a thread some seconds on any machine.
trial() { "$SLO_RT" -q --scene "$scene" --frame=0 --size 128x72 --threads 1 --outdir "$folder/trial" >/dev/null; }
TIMEFORMAT=%U
seconds=$({ time trial; } 2>&1)
size_of() {
    awk -v all="$1" -v one="$seconds" 'BEGIN { s = sqrt(all / (one + 0.01)); printf "%dx%d", 128 * s, 72 * s }'
}
options=(--checkpoint 1 --size "$(size_of 5)")
say "frames: ${options[*]}"
all_done() { [[ -z $(squeue -h -o %i) ]]; }
# Finds the task and job on node n1, once a checkpoint shows that it is in the middle of its frame.
mid_frame() {
    read -r task job < <(squeue -h -t R -w n1 -o '%K %A') && compgen -G "$1"
}
check() {
    local path count=0
    while read -r path; do
        cmp -- "$folder/local/${path##*/}" "$folder/farm/${path##*/}" ||
            fail "${path##*/} is not the one of a local run"
        count=$((count + 1))
    done
    [[ -z $(find "$folder/farm" -name '.slo-rt-*') ]] || fail 'a checkpoint was left'
    say "$count pictures, byte for byte those of a local run"
}

frames=-1-1
array=$("$here/submit.sh" "$scene" "$frames" "${options[@]}" --outdir "$folder/farm")
# The first tasks of the array, frames -1 and 0, start on the two nodes.
await 120 'a checkpoint on node n1' mid_frame "$folder/farm/.slo-rt-*.state"
mapfile -t killed < <(grep -lzFx "SLURM_JOB_ID=$job" $(processes | sed 's|.*|/proc/&/environ|') 2>/dev/null |
    cut -d / -f 3)
mapfile -t steps < <(pgrep -f "^slurmstepd: \[$job\.")
kill -KILL "$node" "${killed[@]}" "${steps[@]}"
say "node n1 is killed in task $task"
await 900 'all frames' all_done
grep -q ', run 2$' "$folder/farm/log/slurm-${array}_$task.log" || fail "task $task was not queued again"
"$SLO_RT" -q --scene "$scene" --frame="$frames" "${options[@]}" --outdir "$folder/local" | check
again=$("$here/submit.sh" "$scene" "$frames" "${options[@]}" --outdir "$folder/farm" 2>&1)
[[ $again == *'all frames are finished' ]] || fail "submitted again: $again"

start slurmd -D -N n1
await 60 'node n1' idle n1
options=(--checkpoint 1 --size "$(size_of 8)")
array=$("$here/submit.sh" --parts 2 "$scene" 5 "${options[@]}" --outdir "$folder/farm")
# The second line is the job that merges.
array=${array%%$'\n'*}
await 120 'a checkpoint on node n1' mid_frame "$folder/farm/parts/.slo-rt-*.state"
# Slurm sends this signal before the time limit.
scancel --batch --signal=USR1 "$job"
say "task $task is stopped"
await 900 'all parts' all_done
grep -q ', run 2$' "$folder/farm/log/slurm-${array}_$task.log" || fail "task $task was not queued again"
"$SLO_RT" -q --scene "$scene" --frame=5 "${options[@]}" --outdir "$folder/local" | check
[[ ! -e $folder/farm/parts ]] || fail 'parts were left'
