#!/bin/sh
# Makes a video of the pictures of a sequence with ffmpeg.

usage='usage: video.sh PREFIX VIDEO [FPS]

Uses the pictures named PREFIX, five digits and .png, in the order of their numbers:
  video.sh output/table/table_ table.mp4 25
FPS should be the frame rate of the scene (default: 25). The frames may start at any number and have
gaps.'

case ${1-} in
-h | --help)
    printf '%s\n' "$usage"
    exit 0
    ;;
esac
if [ $# -lt 2 ] || [ $# -gt 3 ]; then
    printf '%s\n' "$usage" >&2
    exit 2
fi

fail() {
    printf 'video.sh: %s\n' "$1" >&2
    exit 1
}

command -v ffmpeg >/dev/null || fail 'ffmpeg is missing. Systems have it as the package `ffmpeg`; https://ffmpeg.org
has programs for others. Or ask another program to read the pictures: they are plain PNG files.'
set -- "$1" "$2" "${3:-25}" "$1"[0-9][0-9][0-9][0-9][0-9].png
[ -e "$4" ] || fail "there are no pictures \`$1NNNNN.png\`"

# ffmpeg 5 knows no [0-9] in the names of pictures. H.264 needs even sides. Players expect yuv420p
# and the file's index at its start.
exec ffmpeg -y -framerate "$3" -pattern_type glob -i "$1?????.png" \
    -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -c:v libx264 -crf 16 -pix_fmt yuv420p \
    -movflags +faststart "$2"
