#!/usr/bin/env bash
# Renders a picture with all layers and reads it with OpenEXR's own library, from PyPI's OpenEXR, and
# the hashes of masks with PyPI's mmh3; both are fetched once and kept in $XDG_CACHE_HOME/slo-rt-ci.
# Exit code: 0 passed, 1 failed, 3 a library can't be had.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
packages=(OpenEXR==3.5.3 mmh3==5.3.1 'numpy>=1.26')
python=$(python3 -c 'import sys; print("%d.%d" % sys.version_info[:2])') || exit 3
folder=${XDG_CACHE_HOME:-$HOME/.cache}/slo-rt-ci/layers-1-$python
if [[ ! -e $folder/complete ]]; then
    rm -rf -- "$folder"
    timeout "${FETCH_SECONDS:-240}" python3 -m pip install --quiet --no-cache-dir --only-binary :all: \
        --target "$folder" "${packages[@]}" >&2 || { echo 'SKIPPED: OpenEXR cannot be had'; exit 3; }
    touch -- "$folder/complete"
fi
PYTHONPATH=$folder python3 scripts/layers/check.py "${SLO_RT:-target/release/slo-rt}"
