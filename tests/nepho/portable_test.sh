#!/usr/bin/env bash
# nepho_portable: no GDAL among its libraries, one clear line about rasters, the rest as nepho has it.
# Usage: portable_test.sh PATH-OF-NEPHO_PORTABLE PATH-OF-NEPHO
set -euo pipefail
portable=$1 nepho=$2
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
cd "$work"
export NEPHO_CACHE=$work/cache
failures=0
check() {  # check "fact" command...
  if "${@:2}"; then echo "ok: $1"; else
    echo "FAILED: $1"
    failures=$((failures + 1))
  fi
}

check 'no GDAL among its libraries' bash -c '! ldd "$0" | grep -q libgdal' "$portable"
check 'the schema is that of nepho' cmp <("$portable" schema) <("$nepho" schema)
check 'the commands are those of nepho' cmp <("$portable" --help) <("$nepho" --help)
check 'info says that there is no GDAL' bash -c '"$0" info | grep -q "GDAL *none"' "$portable"

: >ground.tif
echo '{"terrain": {"default_earth": false}, "night_sky": {"stars": false, "moon": false}}' >scene.json
for option in --terrain --imagery --weather --weather-tile; do
  status=0
  "$portable" render scene.json $option ground.tif --size 64x36 -o picture.png >out 2>err </dev/null || status=$?
  check "$option: status 3, one line with file and reason, no picture" bash -c \
    "[[ $status == 3 && \$(wc -l <err) == 1 && \$(<err) == *'ground.tif: this build has no GDAL'* && ! -s out && ! -e picture.png ]]"
done
[[ $failures == 0 ]] || { echo "$failures failures"; exit 1; }
