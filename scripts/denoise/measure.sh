#!/usr/bin/env bash
# Prints the tables of docs/denoising.md: the errors of pictures with few samples against a reference with many,
# without denoising, denoised from colours alone, and denoised with layers. A smaller SIZE or REFERENCE (samples)
# makes it faster.
#
#     SIZE=480x270 REFERENCE=512 scripts/denoise/measure.sh default depth_of_field
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
program=$(realpath -- "${SLO_RT:-target/release/slo-rt}")
library=$(scripts/denoise/library.sh)
size=${SIZE:-640x360}
folder=${KEEP:-$(mktemp -d)}
[[ -n ${KEEP:-} ]] || trap 'rm -rf "$folder"' EXIT

# Prints the difference between two pictures: relative mean square error, FLIP.
distances() {
    "$program" compare "$1" "$2" | awk '$1 == "relative-mse" { e = $2 } $1 == "flip" { f = $2 }
        END { printf " %.1e | %.3f |", e, f }'
}

mkdir -p "$folder/scenes"
cp -r meshes textures "$folder"
printf '| scene | samples | noisy | FLIP | colours alone | FLIP | with layers | FLIP |\n|---|---|---|---|---|---|---|---|\n'
for name in "$@"; do
    # All samples everywhere: no adaptive rule of the scene stops a block.
    scene=$folder/scenes/$name.txt
    sed -E 's/(noise|imageMinSamples) +[0-9.]+//g' "scenes/$name.txt" >"$scene"
    render() {
        "$program" -q -s "$scene" --allow-outside --size "$size" --format exr "$@" >/dev/null
    }
    render --samples "${REFERENCE:-1024}" --seed 9 --prefix "${name}_" -od "$folder/clean" --skip-existing
    clean=$folder/clean/${name}_00000.exr
    for samples in 4 16 64; do
        row=$folder/$samples
        render --samples $samples --layers albedo,normal --prefix "${name}_" -od "$row/noisy"
        render --samples $samples --prefix "${name}_" -od "$row/plain"
        picture=${name}_00000.exr
        "$program" denoise -q --library "$library" "$row/plain/$picture" -od "$row/blind" >/dev/null
        "$program" denoise -q --library "$library" "$row/noisy/$picture" -od "$row/guided" >/dev/null
        printf '| `%s` | %s |%s%s%s\n' "$name" "$samples" "$(distances "$row/noisy/$picture" "$clean")" \
            "$(distances "$row/blind/$picture" "$clean")" "$(distances "$row/guided/$picture" "$clean")"
    done
done
