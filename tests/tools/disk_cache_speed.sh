#!/usr/bin/env bash
# How much faster a second render of a view is with a warm disk cache: a 10,000 x 10,000 raster of heights and one of
# colours in UTM (ENVI files, 500 MB in a temporary folder) below a view from 60 km, without clouds.
# Usage: disk_cache_speed.sh PATH-OF-NEPHO [SIZE-OF-THE-RASTERS]
set -euo pipefail
nepho=$1
side=${2:-10000}
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd "$work"

python3 - "$side" <<'PY'
import math, sys
from array import array
side = int(sys.argv[1])
def header(name, bands, kind):
    with open(name + '.hdr', 'w') as f:
        f.write(f'''ENVI
samples = {side}
lines = {side}
bands = {bands}
header offset = 0
file type = ENVI Standard
data type = {kind}
interleave = bsq
byte order = 0
map info = {{UTM, 1, 1, 250000, 3950000, 10, 10, 54, North, WGS-84}}
''')
heights = array('h', (int(1500 + 900 * math.sin(i * 0.0021) + 300 * math.sin(i * 0.037) + (i * 7919 % 41))
                      for i in range(2 * side)))
with open('heights', 'wb') as f:
    for y in range(side):
        first = (y * 3) % side
        f.write(heights[first:first + side].tobytes())
header('heights', 1, 2)
colours = bytes((60 + (i * 31 + i // 97) % 120) for i in range(2 * side))
with open('colours', 'wb') as f:
    for band in range(3):
        for y in range(side):
            first = (y * (band + 2)) % side
            f.write(colours[first:first + side])
header('colours', 3, 1)
PY

field() { grep -m1 "\"$1\"" "$2" | tr -dc '0-9.'; }
first_frame_ms() {  # start-up and ground of a timings file, ms
  awk "BEGIN { printf \"%.0f\", $(field startup_ms "$1") + $(field terrain_ms "$1") }"
}
export NEPHO_CACHE=$work/cache
echo "rasters of $side x $side, $(nproc) cores, load $(cut -d" " -f1 /proc/loadavg)"
scene=(--at 35.2,138.8 --height 60000 --pitch -90 --fov 60 --time 2026-06-20T03:00:00Z --coverage 0 --size 320x180)
"$nepho" render "${scene[@]}" -o plain.png 2>plain.txt  # the cache of the atmosphere's tables
scene+=(--terrain heights --imagery colours)
for run in cold warm; do
  "$nepho" render "${scene[@]}" -o "$run.exr" -o "$run.png" --aov depth,albedo --timings "$run.json"
  echo "$run: $(first_frame_ms "$run.json") ms to the first frame; terrain $(field terrain_ms "$run.json") ms; blocks read $(field blocks_read "$run.json"), from disk $(field blocks_from_disk "$run.json")"
done
NEPHO_CACHE=$work/none "$nepho" render "${scene[@]}" --disk-cache 0 -o off.png
# Headers of EXR files have the scene with its settings of the cache.
cmp cold.exr warm.exr && cmp cold.png off.png && echo "the same bits, and the same picture as without the cache"
du -sh "$work/cache/blocks"
echo "$(awk "BEGIN { printf \"%.1f\", $(first_frame_ms cold.json) / $(first_frame_ms warm.json) }") times as fast"
