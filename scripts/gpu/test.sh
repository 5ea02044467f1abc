#!/usr/bin/env bash
# Traversal on a GPU against the CPU's: rays one by one, and pictures of shipped scenes, byte for byte.
# --install: installs lavapipe, Mesa's Vulkan in software, as root by apt-get.
# Exit code: 0 passed, 1 failed, 3 there is no adapter.
set -euo pipefail
cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.."
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

lavapipe() { compgen -G '/usr/share/vulkan/icd.d/lvp_icd*.json' || true; }

skip() {
    echo "SKIPPED: traversal on a GPU is not tested: $1" >&2
    exit 3
}

if [[ ${1:-} == --install && -z $(lavapipe) && -z ${VK_ICD_FILENAMES:-} ]]; then
    { [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null; } || skip 'lavapipe is installed by root, by apt-get'
    { apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qq install -y mesa-vulkan-drivers; } \
        >"$folder/log" 2>&1 || { tail -n 5 "$folder/log" >&2; skip 'lavapipe cannot be installed'; }
fi
# What is compared on a machine must not depend on its other drivers, unless the caller chooses one.
if [[ -z ${VK_ICD_FILENAMES:-} && -n $(lavapipe) ]]; then
    VK_ICD_FILENAMES=$(lavapipe | head -n 1)
    export VK_ICD_FILENAMES
fi
[[ -n ${VK_ICD_FILENAMES:-} ]] || skip 'there is no lavapipe; --install installs it'
export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-$folder}

# One graph of dependencies for both packages, the one of `cargo test`, so that little is compiled again.
read -ra profile <<<"${SLO_RT_PROFILE---release}"
SLO_REQUIRE_GPU=1 ${CARGO:-cargo} test "${profile[@]}" --workspace --features gpu,slo-gpu/device \
    --test traversal --test gpu
