#!/usr/bin/env bash
# Fuzzes what reads files and requests of others; docs/fuzzing.md says how it works.
#
#   scripts/fuzz.sh [TARGET...] [--seconds N | --runs N] [--long] [--corpus FOLDER] [--list]
#
# Without TARGET, all of them. Needs a C++ compiler, and crates.io once; ends with 3 without them.
# --long repeats a part of each input until there is 1 MB of it. Inputs that reach new code are kept in the
# corpus (fuzz/corpus), those that break a promise in fuzz/artifacts.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../fuzz"

all=$(cd src/targets && ls -- *.rs | sed '/^mod\.rs$/d; s/\.rs$//')
targets=() limit=(-max_total_time=60) corpus=corpus long=() timeout=20
while (($#)); do
    case $1 in
    --seconds) limit=("-max_total_time=$2") && shift ;;
    --runs) limit=("-runs=$2") && shift ;;
    --long) long=(SLO_FUZZ_LONG=1) timeout=60 ;;
    --corpus) corpus=$(realpath -m -- "$OLDPWD/$2") && shift ;;
    --list) printf '%s\n' "$all" && exit ;;
    -*) sed -n '2,8s/^# \?//p' "../scripts/fuzz.sh" >&2 && exit 2 ;;
    *) grep -qx -- "$1" <<<"$all" || { echo "no such target: $1" >&2 && exit 2; }
        targets+=("$1") ;;
    esac
    shift
done
((${#targets[@]})) || mapfile -t targets <<<"$all"

skip() {
    echo "SKIPPED: nothing is fuzzed, since $1" >&2
    exit 3
}
c++ -std=c++17 -x c++ - -o /dev/null <<<'int main() {}' 2>/dev/null || skip 'there is no C++ compiler'
cargo fetch --quiet || skip 'libFuzzer cannot be fetched'

# Marks every edge and every comparison of our code and of all libraries, with a stable compiler.
llvm() { printf -- '-Cllvm-args=-sanitizer-coverage-%s ' "$@"; }
export RUSTFLAGS="-Cpasses=sancov-module $(llvm level=4 inline-8bit-counters pc-table trace-compares) --cfg fuzzing"
host=$(rustc -vV | sed -n 's/^host: //p')
# For the host by name: build scripts and macros are then built without the marks.
cargo build --quiet --package slo-fuzz --features libfuzzer --profile fuzz --target "$host" --target-dir target
program=target/$host/fuzz/fuzz

mkdir -p "$corpus" artifacts
for target in "${targets[@]}"; do
    [[ -e $corpus/$target ]] && continue
    [[ -e target/seeds/$target ]] || SLO_FUZZ_SEEDS=target/seeds "$program" >target/seeds.log 2>&1
    cp -r -- "target/seeds/$target" "$corpus"
done

# Words of the scene language, as libFuzzer takes them.
grep -ohE '[A-Za-z_][A-Za-z_0-9]+' ../scenes/*.txt ../docs/scene-format.md ../crates/slo-scene/tests/scenes/*.txt |
    sort -u | sed 's/.*/"&"/' >target/words

failed=0
for target in "${targets[@]}"; do
    mkdir -p "$corpus/$target" "artifacts/$target"
    words=()
    case $target in scene | render | edit | view | recipe) words=(-dict=target/words) ;; esac
    env "${long[@]}" "SLO_FUZZ_TARGET=$target" "$program" "$corpus/$target" "${limit[@]}" "${words[@]}" \
        "-artifact_prefix=artifacts/$target/" -max_len=16384 -timeout=$timeout -rss_limit_mb=2048 \
        -print_final_stats=1 -verbosity="${SLO_FUZZ_VERBOSITY:-0}" >"target/$target.log" 2>&1 || {
        tail -n 60 "target/$target.log"
        failed=1
    }
    sed -n "s/^stat::number_of_executed_units: */$target: /p" "target/$target.log"
done
exit "$failed"
