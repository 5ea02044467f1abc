#!/usr/bin/env bash
# Prints the path of Open Image Denoise's library: $OIDN, or the library in PyPI's pyoidn (88 MB, for
# Linux on x86-64), which is fetched once and kept in $XDG_CACHE_HOME/slo-rt-ci.
# Exit code: 0 found, 3 not available.
set -euo pipefail
version=2.5.1.0
folder=${XDG_CACHE_HOME:-$HOME/.cache}/slo-rt-ci/pyoidn-$version
library=$folder/pyoidn/oidn/lib/libOpenImageDenoise.so.2

if [[ -n ${OIDN:-} ]]; then
    printf '%s\n' "$OIDN"
    exit
fi
if [[ ! -e $folder/complete ]]; then
    # Only the library is needed, not the Python packages that it depends on.
    rm -rf -- "$folder"
    timeout "${FETCH_SECONDS:-240}" python3 -m pip install --quiet --no-deps --no-cache-dir \
        --target "$folder" "pyoidn==$version" >&2 || exit 3
    [[ -e $library ]] || exit 3
    touch -- "$folder/complete"
fi
printf '%s\n' "$library"
