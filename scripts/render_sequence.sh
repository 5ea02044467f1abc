#!/bin/sh
# Renders the frames of a scene, each in a run of slo-rt, one after the other.

usage='usage: render_sequence.sh [-k] SCENE FIRST LAST [options of slo-rt]

Renders the frames FIRST to LAST of SCENE. Further options are passed to slo-rt:
  render_sequence.sh table.txt 0 100 -od output/table
  render_sequence.sh table.txt 0 100 -od output/table --skip-existing    (continues a sequence)

  -k, --keep-going   continues after a frame that fails, and lists the failed frames at the end

The program is $SLO_RT, or slo-rt of this checkout (target/release), or slo-rt on the PATH.
Exit code: 0 all frames are finished; the exit code of slo-rt for the frame at which it stopped;
1 some frames failed (-k); 2 wrong usage; 130 interrupted.'

fail_usage() {
    printf '%s\n\n%s\n' "render_sequence.sh: $1" "$usage" >&2
    exit 2
}

is_integer() {
    case ${1#-} in
    '' | *[!0-9]*) return 1 ;;
    # The shell would read a number with a leading zero as octal.
    0?*) return 1 ;;
    esac
}

keep_going=
case ${1-} in
-k | --keep-going)
    keep_going=1
    shift
    ;;
-h | --help)
    printf '%s\n' "$usage"
    exit 0
    ;;
esac
[ $# -ge 3 ] || fail_usage 'SCENE, FIRST and LAST are needed'
scene=$1 first=$2 last=$3
shift 3
is_integer "$first" || fail_usage "FIRST is \`$first\`, not a whole number"
is_integer "$last" || fail_usage "LAST is \`$last\`, not a whole number"
[ "$first" -le "$last" ] || fail_usage "FIRST ($first) comes after LAST ($last)"

here=$(dirname -- "$0")
if [ -n "${SLO_RT-}" ]; then
    program=$SLO_RT
elif [ -x "$here/../target/release/slo-rt" ]; then
    program=$here/../target/release/slo-rt
else
    program=slo-rt
fi

trap 'exit 130' INT
trap 'exit 143' TERM
failed=
frame=$first
while [ "$frame" -le "$last" ]; do
    "$program" --scene "$scene" --frame "$frame" "$@"
    code=$?
    case $code in
    0) ;;
    130) exit 130 ;;
    *)
        printf 'render_sequence.sh: frame %s failed with exit code %s\n' "$frame" "$code" >&2
        [ -n "$keep_going" ] || exit "$code"
        failed="$failed $frame"
        ;;
    esac
    frame=$((frame + 1))
done
if [ -n "$failed" ]; then
    printf 'render_sequence.sh: failed frames:%s\n' "$failed" >&2
    exit 1
fi
