#!/bin/sh
# Makes a video of the pictures of a sequence, with ffmpeg.

usage='usage: video.sh PREFIX VIDEO [FPS]

Takes the pictures PREFIX followed by five digits and .png, in the order of their numbers, such as
  video.sh output/table/table_ table.mp4 25
FPS is 25 where it is not given: take that of the scene. Frames may start anywhere and have gaps.'

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

# H.264 wants even sides; yuv420p and the file's index in front are what players expect.
exec ffmpeg -y -framerate "${3:-25}" -pattern_type glob -i "$1[0-9][0-9][0-9][0-9][0-9].png" \
    -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -c:v libx264 -crf 16 -pix_fmt yuv420p \
    -movflags +faststart "$2"
