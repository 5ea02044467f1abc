#!/usr/bin/env bash
# Makes the files of a release from a clean checkout.
#
#   scripts/release.sh [--out FOLDER] [--check]
#
#   --out FOLDER   where the files go [default: target/release-files]
#   --check        build a second time in another folder, and fail if a byte differs
#
# For each kind of program one archive with the program, its manual pages, completions of shells, documentation, and the
# licences of all its parts:
#   slo-rt-VERSION-x86_64-linux.tar.gz          for the C library of this system or a newer one
#   slo-rt-VERSION-x86_64-linux-static.tar.gz   for every Linux; it can't load Open Image Denoise
# Beside them: the packages of all crates, the Blender extension, a bill of materials, and SHA256SUMS.
#
# Needs Rust, Python 3.11, GNU tar and gzip; libc.a for the static program. Two builds take about ten minutes.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
out=$root/target/release-files
check=
while (($#)); do
    case $1 in
    --out) out=$(mkdir -p "$2" && cd "$2" && pwd) && shift ;;
    --check) check=1 ;;
    -h | --help) sed -n '2,/^set/{/^set/d;s/^# \{0,1\}//;p}' "$0" && exit ;;
    *) echo "release.sh: unknown argument $1" >&2 && exit 2 ;;
    esac
    shift
done

target=$(rustc -vV | sed -n 's/^host: //p')
version=$(sed -n 's/^version = "\(.*\)"/\1/p' "$root/Cargo.toml" | head -n 1)
system=${target%%-*}-linux
# Everything is as old as the commit.
SOURCE_DATE_EPOCH=$(git -C "$root" log -1 --format=%ct)
export SOURCE_DATE_EPOCH LC_ALL=C
if [[ -n $(git -C "$root" status --porcelain) ]]; then
    echo 'release.sh: the checkout has changes that are not committed; the files will not be of any commit' >&2
fi

# Builds the program in a folder: build SOURCE KIND
build() {
    local flags="--remap-path-prefix=$1=/slo-rt --remap-path-prefix=${CARGO_HOME:-$HOME/.cargo}=/cargo"
    flags+=" --remap-path-prefix=$(rustc --print sysroot)=/rust"
    [[ $2 == static ]] && flags+=' -C target-feature=+crt-static'
    # The target is named so that the flags don't apply to build scripts.
    (cd "$1" && CARGO_TARGET_DIR=$1/target/for-release-$2 RUSTFLAGS=$flags cargo build --release --locked \
        --target "$target" --bin slo-rt --config 'profile.release.strip="symbols"' --config 'profile.release.debug=false')
}

built() {
    echo "$1/target/for-release-$2/$target/release/slo-rt"
}

# Packs a folder so that the same files make the same bytes: pack FOLDER ARCHIVE
pack() {
    tar --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --mode=u+rw,go+r,go-w \
        -C "$(dirname "$1")" -c "$(basename "$1")" | gzip -9n >"$2"
}

mkdir -p "$out"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for kind in dynamic static; do
    build "$root" $kind
    [[ $kind == static ]] && name=slo-rt-$version-$system-static || name=slo-rt-$version-$system
    folder=$work/$name
    mkdir -p "$folder"/{man/man1,completions,docs}
    cp "$(built "$root" $kind)" "$folder/"
    program=$folder/slo-rt
    "$program" generate man >"$folder/man/man1/slo-rt.1"
    commands=$("$program" --help | sed -n '/^Other commands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
    [[ -n $commands ]] || { echo 'release.sh: the help names no commands' >&2 && exit 1; }
    for command in $commands; do
        "$program" generate man "$command" >"$folder/man/man1/slo-rt-$command.1"
    done
    "$program" generate bash >"$folder/completions/slo-rt.bash"
    "$program" generate fish >"$folder/completions/slo-rt.fish"
    "$program" generate zsh >"$folder/completions/_slo-rt"
    "$program" generate elvish >"$folder/completions/slo-rt.elv"
    "$program" generate powershell >"$folder/completions/_slo-rt.ps1"
    cp "$root"/{README.md,CHANGELOG.md,LICENSE-MIT,LICENSE-APACHE} "$folder/"
    cp "$root"/docs/*.md "$folder/docs/"
    "$root/scripts/release/licences.py" --target "$target" --texts "$folder/LICENSES-OF-PARTS.txt" \
        --sbom "$out/slo-rt-$version.cdx.json"
    pack "$folder" "$out/$name.tar.gz"
done

if [[ -n $check ]]; then
    other=$work/elsewhere/slo-rt
    mkdir -p "$other"
    (cd "$root" && git ls-files -z | xargs -0 cp --parents -t "$other")
    for kind in dynamic static; do
        build "$other" $kind
        cmp "$(built "$root" $kind)" "$(built "$other" $kind)"
        echo "the $kind program is the same from two folders"
    done
fi

# Packages of crates, as crates.io would have them.
(cd "$root" && cargo package --workspace --allow-dirty --no-verify --locked --quiet)
for package in "$root"/target/package/*-"$version".crate; do
    size=$(stat -c %s "$package")
    if ((size > 2000000)); then
        echo "release.sh: $(basename "$package") has $size bytes, more than 2 MB" >&2
        exit 1
    fi
    cp "$package" "$out/"
done

# The extension: the zip that Blender would build, with files in their order and as old as the commit.
"$root/scripts/release/extension.py" "$root/scripts/blender/slo_rt" "$out"

(cd "$out" && sha256sum ./*.tar.gz ./*.crate ./*.zip ./*.json | sed 's|\./||' >SHA256SUMS)
(cd "$out" && ls -l && sha256sum --quiet -c SHA256SUMS)
echo "the files are in $out"
