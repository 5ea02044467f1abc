#!/usr/bin/env bash
# Opens the page of `slo-rt view` in a real browser, Chromium, and uses it as a person does. `--install`
# gets Chromium by apt-get if this is root on Debian. playwright-core comes from npm, once, and is kept in
# $XDG_CACHE_HOME/slo-rt-ci. `--pictures FOLDER` writes a screenshot, and
# `--latency` measures how soon a change is seen. `--soak MINUTES` clicks, drags, types and saves at random.
# Exit code: 0 passed, 1 failed, 3 a browser can't be had.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

skip() {
    echo "SKIPPED: the viewer is not tested in a browser: $*"
    exit 3
}

browser() {
    command -v chromium || command -v chromium-browser || command -v google-chrome
}

if [[ ${1:-} == --install ]]; then
    shift
    if ! browser >/dev/null && [[ $(id -u) == 0 ]] && command -v apt-get >/dev/null; then
        timeout "${FETCH_SECONDS:-240}" apt-get install --yes --quiet --no-install-recommends chromium >/dev/null 2>&1 ||
            skip 'apt-get has no Chromium today'
    fi
fi
CHROMIUM=${CHROMIUM:-$(browser || true)}
[[ -n $CHROMIUM ]] || skip 'there is no Chromium'
command -v node >/dev/null && command -v npm >/dev/null || skip 'there is no Node.js with npm'

version=1.65.1
folder=${XDG_CACHE_HOME:-$HOME/.cache}/slo-rt-ci/view-$version
if [[ ! -e $folder/complete ]]; then
    rm -rf -- "$folder"
    mkdir -p -- "$folder"
    timeout "${FETCH_SECONDS:-240}" npm install --silent --no-fund --no-audit --ignore-scripts \
        --prefix "$folder" "playwright-core@$version" >&2 || skip 'npm has no playwright-core today'
    touch -- "$folder/complete"
fi
PLAYWRIGHT=$folder/node_modules/playwright-core/index.mjs CHROMIUM=$CHROMIUM \
    node scripts/view/test.mjs "${SLO_RT:-target/release/slo-rt}" "$@"
