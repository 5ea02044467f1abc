#!/usr/bin/env bash
# Counts the instructions of rays on AArch64, in qemu: per ray of each set, by NEON and in plain Rust.
# MESH.tri and RAYS.rays are those of slo-accel's example trace_rays. Needs what test.sh needs, gcc, and a
# qemu with plugins.
#   count.sh MESH.tri RAYS.rays [ACCELERATOR]
set -euo pipefail
[[ $# -ge 2 ]] || { sed -n '2,6s/^# //p' "$0"; exit 2; }
mesh=$(realpath "$1")
rays=$(realpath "$2")
accelerator=${3:-BVH}
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
target=aarch64-unknown-linux-gnu
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT

gcc -shared -fPIC -O2 -o "$folder/count.so" scripts/aarch64/count.c
export CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER=aarch64-linux-gnu-gcc
cargo build --quiet --release --target "$target" -p slo-accel --example trace_rays
program=${CARGO_TARGET_DIR:-target}/$target/release/examples/trace_rays

# A file for each set, with empty sets before it: the first three are taken for coherent rays.
python3 - "$rays" "$folder" <<'PYTHON'
import struct
import sys

MOST = 16384
data = open(sys.argv[1], "rb").read()
(sets,), at = struct.unpack_from("<I", data), 4
for number in range(sets):
    count, kind = struct.unpack_from("<II", data, at)
    rays = at + 8
    hits = rays + 32 * count
    at = hits + 8 * count
    kept = min(count, MOST)
    with open(f"{sys.argv[2]}/{number}.rays", "wb") as file:
        file.write(struct.pack("<I", number + 1) + bytes(8 * number) + struct.pack("<II", kept, kind))
        file.write(data[rays : rays + 32 * kept] + data[hits : hits + 8 * kept])
    print(kept, file=open(f"{sys.argv[2]}/{number}.count", "w"))
PYTHON

count() { # ISA SET REPEATS
    qemu-aarch64 -L /usr/aarch64-linux-gnu -plugin "$folder/count.so" "$program" "$mesh" "$folder/$2.rays" \
        --accelerator "$accelerator" --isa "$1" --repeat "$3" 2>&1 >/dev/null | sed -n 's/ instructions$//p'
}

for isa in neon portable; do
    for rays in "$folder"/*.rays; do
        set=$(basename "$rays" .rays)
        # Two more passes: what building takes falls out.
        once=$(count "$isa" "$set" 1)
        thrice=$(count "$isa" "$set" 3)
        echo "$isa, set $set: $(((thrice - once) / 2 / $(<"$folder/$set.count"))) instructions per ray"
    done
done
