#!/usr/bin/env bash
# Tests slo-accel on AArch64 under qemu, and compares two pictures with those of this machine's program,
# byte by byte. What it needs: Rust's library for AArch64 (rustup), aarch64-linux-gnu-gcc, qemu-aarch64.
#   test.sh             tests if all of this is there
#   test.sh --install   fetches it before, by rustup and apt-get (root on Debian or Ubuntu; 0.3 GB)
# Exit code: 0 passed, 1 failed, 3 something that it needs is missing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
target=aarch64-unknown-linux-gnu
library=/usr/aarch64-linux-gnu

missing() {
    printf 'SKIPPED: %s\n' "$1"
    exit 3
}
has_rust() { [[ -d $(rustc --print sysroot)/lib/rustlib/$target/lib ]]; }
has_tools() { command -v aarch64-linux-gnu-gcc qemu-aarch64 >/dev/null && [[ -e $library/lib/libc.so.6 ]]; }

if [[ ${1-} == --install ]]; then
    has_rust || timeout "${FETCH_SECONDS:-600}" rustup target add "$target" >&2 || true
    has_tools || timeout "${FETCH_SECONDS:-600}" apt-get install -y -qq --no-install-recommends \
        gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user >&2 || true
fi
has_rust || missing "Rust has no library for $target; rustup target add $target adds it"
has_tools || missing 'aarch64-linux-gnu-gcc, its C library, or qemu-aarch64 is not installed'

export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER="qemu-aarch64 -L $library"

# Left out: what takes minutes under qemu and holds no code of AArch64.
cargo test --target "$target" -p slo-accel --lib -- --skip study --skip kdtree --skip cwbvh

cargo build --target "$target" -p slo-rt
program=${SLO_RT:-target/release/slo-rt}
[[ -x $program ]] || missing "there is no program $program to compare with; cargo build --release makes it"
emulated=${CARGO_TARGET_DIR:-target}/$target/debug/slo-rt
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT

render() { # WHERE SCENE PROGRAM...
    mkdir "$folder/$1"
    "${@:3}" --scene "scenes/$2.txt" --outdir "$folder/$1" --size 96x54 --samples 4 >/dev/null
}

for scene in still_life daylight; do
    render "$scene" "$scene" "$program"
    for isa in neon portable; do
        SLO_RT_ISA=$isa render "$scene-$isa" "$scene" qemu-aarch64 -L "$library" "$emulated"
        diff -r "$folder/$scene" "$folder/$scene-$isa"
        echo "$scene: the same bytes by $isa on AArch64"
    done
done
