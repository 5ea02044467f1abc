#!/usr/bin/env bash
# Denoises pictures with the real library and checks that they get closer to clean ones.
# Exit code: 0 passed, 1 failed, 3 Open Image Denoise is not available.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
program=$(realpath -- "${SLO_RT:-target/release/slo-rt}")
library=$(scripts/denoise/library.sh) || {
    echo 'SKIPPED: the test of denoising needs Open Image Denoise, by Python 3 and PyPI' >&2
    exit 3
}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

render() { "$program" -q --size 320x180 "$@" >"$folder/path"; }
denoise() { "$program" denoise -q --library "$library" "$@" >"$folder/path"; }

fail() {
    printf 'denoising: %s\n' "$1" >&2
    exit 1
}

# Prints the relative mean square error of a picture.
error() {
    "$program" compare "$1" "$2" | sed -n 's/^relative-mse\t//p'
}

# Tests whether A is below B times C.
below() {
    awk -v a="$1" -v b="$2" -v c="$3" 'BEGIN { exit !(a < b * c) }'
}

# Wood, cloth, rough and polished pieces behind a lens: with few samples, and a reference with many.
scene=scenes/default.txt
layers=(--format exr --layers 'albedo,normal')
render -s $scene --noise 0.002 --samples 512 --format exr --seed 9 -od "$folder/clean"
render -s $scene --noise 0.5 --samples 4 "${layers[@]}" -od "$folder/noisy"
render -s $scene --noise 0.5 --samples 4 --format exr -od "$folder/plain"
render -s $scene --noise 0.5 --samples 4 -od "$folder"
name=default_00000.exr
denoise "$folder/noisy/$name" -od "$folder/guided"
denoise "$folder/plain/$name" -od "$folder/blind"
denoise "$folder/default_00000.png"

clean=$folder/clean/$name
noisy=$(error "$folder/noisy/$name" "$clean")
guided=$(error "$folder/guided/$name" "$clean")
blind=$(error "$folder/blind/$name" "$clean")
printf 'relative mean square error: %s noisy, %s denoised, %s without layers\n' "$noisy" "$guided" "$blind"
below "$guided" "$noisy" 0.5 || fail 'the error has not fallen by half'
below "$guided" "$blind" 1 || fail 'the layers do not help'
[[ -s $folder/default_00000_denoised.png ]] || fail 'a PNG is not denoised'
below "$(error "$folder/default_00000_denoised.png" "$folder/default_00000.png")" 1 1 ||
    fail 'the denoised PNG shows something else'

# Fine detail that the layers show is preserved: a checkered wall under a lamp that is half hidden.
cat >"$folder/wall.txt" <<'SCENE'
settings s { imageSamples 2 softShadowSamples 1 recursion 0 }
Camera c {
    fps 25
    Film f { width 320 height 180 prefix wall_ output EXR_IMAGE }
    CamSegment only { videoStart 0 videoEnd 1 sceneStart 0 sceneEnd 1
        addPosition { 0 -10 0 } addTarget { 0 0 0 } skyStart { 0 0 1 } fovStart .5 }
}
light_rectangle lamp { color { 1 1 1 }
    vertex0 { -8 -12 9 } vertex1 { 8 -12 9 } vertex2 { 8 -4 9 } }
texture checker { filename textures/checker.png }
phong_info paint { diffuse { .8 .8 .8 } }
material_texture wall { phong_info paint texture checker scale_U 6 scale_V 6 }
material_phong post { phong_info paint }
rectangle wall { material wall vertex0 { -9 0 -5 } vertex1 { 9 0 -5 } vertex2 { 9 0 5 } }
box post { material post vertex0 { -1 -6 3 } vertex1 { 1 -6 3 } vertex2 { 1 -4 3 } height 2 }
SCENE
cp -r textures "$folder"
wall=wall_00000.exr
render -s "$folder/wall.txt" --samples 1024 --seed 9 -od "$folder/clean"
render -s "$folder/wall.txt" --layers albedo,normal -od "$folder/noisy"
render -s "$folder/wall.txt" -od "$folder/plain"
denoise "$folder/noisy/$wall" -od "$folder/guided"
denoise "$folder/plain/$wall" -od "$folder/blind"
clean=$folder/clean/$wall
noisy=$(error "$folder/noisy/$wall" "$clean")
guided=$(error "$folder/guided/$wall" "$clean")
blind=$(error "$folder/blind/$wall" "$clean")
printf 'of a fine texture: %s noisy, %s denoised, %s without layers\n' "$noisy" "$guided" "$blind"
below "$guided" "$noisy" 0.5 || fail 'a texture is blurred'
below "$guided" "$blind" 0.8 || fail 'layers do not keep a texture'

# A region keeps its place in the picture.
region=default_00000_region=96x64+40+50.exr
render -s $scene --noise 0.5 --samples 4 "${layers[@]}" --region 96x64+40+50 -od "$folder/noisy"
denoise "$folder/noisy/$region" -od "$folder/guided"
"$program" compare "$folder/guided/$region" "$folder/clean/$name" >"$folder/said" ||
    fail 'a denoised region is not placed'

# A denoised picture is never mistaken for a rendered one, and its metadata say that it is denoised.
denoised=$folder/guided/$name
"$program" --recipe "$denoised" | grep -q '"denoised": "Open Image Denoise [0-9.]*: albedo, normal"' ||
    fail 'the recipe does not say that it is denoised'
"$program" -s $scene --size 320x180 --noise 0.5 --samples 4 "${layers[@]}" -f 0-0 -od "$folder/guided" --dry-run |
    grep -q 'stale (denoised' || fail 'a sequence takes a denoised picture for its own'
for refused in 'verify -s scenes/default.txt' "denoise --library $library"; do
    code=0
    # shellcheck disable=SC2086
    "$program" $refused "$denoised" >/dev/null 2>"$folder/said" || code=$?
    [[ $code == 65 ]] && grep -q 'is denoised' "$folder/said" || fail "$refused: $(cat "$folder/said")"
done
code=0
denoise "$folder/noisy/$name" -od "$folder/noisy" 2>/dev/null || code=$?
[[ $code == 2 ]] || fail 'a picture is replaced by its denoised self'

# The same bytes again, on another number of threads.
denoise "$folder/noisy/$name" -od "$folder/again" --threads 1
cmp "$folder/guided/$name" "$folder/again/$name" || fail 'other bytes on one thread'
