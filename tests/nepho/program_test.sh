#!/usr/bin/env bash
# Facts about the program itself: exit statuses, one line on standard error, no partial files.
# Usage: program_test.sh PATH-OF-NEPHO
set -euo pipefail
nepho=$1
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd "$work"
failures=0
export NEPHO_CACHE=$work/cache

# fails STATUS "text that the message has" arguments...: one line on standard error, nothing else, no picture
fails() {
  local wanted=$1 text=$2 status=0
  shift 2
  "$nepho" "$@" >out 2>err </dev/null || status=$?
  if [[ $status == "$wanted" && $(wc -l <err) == 1 && $(<err) == *"$text"* && ! -s out && -z $(compgen -G '*picture*') ]]; then
    echo "ok: $wanted: $(<err)"
  else
    echo "FAILED: nepho $*: status $status, not $wanted with one line that has '$text'; standard error:"
    cat err
    ls
    failures=$((failures + 1))
  fi
}
fails_render() { fails "$1" "$2" render --size 64x36 -o picture.exr -o picture.png "${@:3}"; }

echo '{"clouds": {"coverage": 0.4,}}' >broken.json
echo '{"clouds": {"covrage": 0.4}}' >unknown_key.json
echo '{"atmosphere": {"top_height_m": 5000}}' >thin_air.json
echo '{"time": "2200-01-01"}' >late.json
echo '{"clouds": {"layers": [{}, {}, {}, {}, {}]}}' >five_layers.json
echo '{"clouds": {"layers": [{"thickness_m": -1}]}}' >inverted_layer.json
printf 'P5 4 3 255\n123456789012' >no_georeference.pgm
printf 'ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nnodata_value -1\n1 2\n3 4\n' >plain.asc
echo 'LOCAL_CS["nowhere"]' >plain.prj
head -c 100 /dev/urandom >noise.tif

fails 2 'a command is missing'
fails 2 "did you mean 'render'" rendre
fails 2 'tour: not supported yet' tour a.kml -o picture.mp4
fails_render 2 '91' --at 91,0
fails_render 2 '--size: width: 0' --size 0x0
fails_render 2 '16384' --size 100000x100000
fails_render 2 "did you mean 'fuji'" --place fugi
fails_render 2 "did you mean '--coverage'" --covrage 0.4
fails_render 3 'x.grib2: no such file' --weather x.grib2
fails_render 2 'give one of the two' --weather noise.tif --coverage 0.4
fails_render 2 "did you mean 'storm'" --sky stormy
fails_render 2 "did you mean 'density'" --debug densty
fails_render 3 'noise.tif' --weather noise.tif
fails_render 3 'noise.tif' --weather-tile noise.tif
fails_render 3 'no_georeference.pgm' --weather no_georeference.pgm
fails_render 3 '5 items found; 4 at most' five_layers.json
fails_render 3 'thickness_m: -1 is out of range' inverted_layer.json
fails_render 2 "--aov: 'dept'" --aov dept
fails 2 '.exr or .png' render -o picture.jpg
fails_render 3 'no such file' missing.json
fails_render 3 'line 1, column' broken.json
fails_render 3 "did you mean 'coverage'" unknown_key.json
fails_render 3 'missing.tif: no such file' --terrain missing.tif
fails_render 3 'noise.tif' --terrain noise.tif --strict
fails_render 3 'no_georeference.pgm' --terrain no_georeference.pgm --strict
fails_render 3 'no_georeference.pgm' --imagery no_georeference.pgm --strict
fails_render 3 'plain.asc' --terrain plain.asc --strict
VK_ICD_FILENAMES=/nonexistent VK_DRIVER_FILES=/nonexistent fails_render 4 'Vulkan'
fails_render 4 'no-such-device' --device no-such-device
fails 5 'cannot be written' render -o /nonexistent/picture.png
mkdir folder.png
fails 5 'is a folder' render -o folder.png
fails 2 'no_such_kind' probe no_such_kind
fails 2 "did you mean 'bruneton-demo'" probe transmittance --atmosphere brunton-demo
fails_render 2 'more than gas alone' --visibility 1e6
fails_render 3 'the air is too thin' thin_air.json
fails_render 3 'is outside 1900..2100' late.json

# probe_fails STATUS TABLE "text": the same with a table on standard input
probe_fails() {
  local status=0
  printf '%b' "$2" | "$nepho" probe transmittance "${@:4}" >out 2>err || status=$?
  if [[ $status == "$1" && $(wc -l <err) == 1 && $(<err) == *"$3"* && ! -s out ]]; then
    echo "ok: $1: $(<err)"
  else
    echo "FAILED: nepho probe transmittance ${*:4}: status $status, not $1 with '$3'; standard error:"
    cat err
    failures=$((failures + 1))
  fi
}
probe_fails 3 'r_m,mu\n6378137,2\n' "line 2, column 'mu'" --device no-such-device
probe_fails 4 'r_m,mu\n6378137,1\n' 'no-such-device' --device no-such-device
VK_ICD_FILENAMES=/nonexistent VK_DRIVER_FILES=/nonexistent probe_fails 4 'r_m,mu\n6378137,1\n' 'Vulkan'

"$nepho" info --json >out 2>err
if ! grep -q '"geostationary"' out || [[ -s err ]]; then
  echo "FAILED: info --json"
  failures=$((failures + 1))
fi

echo "$failures failed"
((failures == 0))
