#!/usr/bin/env bash
# The packaged folder: small, whole, and of one picture with nepho wherever it lies and whatever the environment holds.
# Usage: package_test.sh BUILD_DIR
set -euo pipefail
build=$1
source=$(cd -- "$(dirname -- "${BASH_SOURCE[0]}")/../.." && pwd)
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
failures=0
check() {  # check "fact" command...
  if "${@:2}"; then echo "ok: $1"; else
    echo "FAILED: $1"
    failures=$((failures + 1))
  fi
}

"$source/cmake/package_folder.sh" "$build" "$work/made"
mkdir -p "$work/elsewhere" "$work/home"
mv "$work/made" "$work/elsewhere/a folder"
folder="$work/elsewhere/a folder"
ln -s "$folder/nepho" "$work/link"
check 'less than 64 MB' test "$(du -sb "$folder" | cut -f1)" -lt 64000000
check 'no links' test -z "$(find "$folder" -type l)"

libraries=$folder/lib:$(printf '%s:' "$folder"/lib/shared/*)
resolved=$(LD_LIBRARY_PATH=$libraries ldd "$folder/bin/nepho")
outside=$(awk '$2 == "=>" {print $1, substr($0, index($0, "=>") + 3)}' <<<"$resolved" | grep -vF "$folder/" |
  grep -vE '^(libc|libm|libdl|librt|libpthread)\.so\.[0-9]+ ' || true)
check "all libraries but glibc are in the folder: $outside" test -z "$outside"

# Another machine: no environment but the way to this one's Vulkan driver, another home, sources out of reach by name.
alone=(env -i "HOME=$work/home" ${VK_DRIVER_FILES+"VK_DRIVER_FILES=$VK_DRIVER_FILES"})
cd "$work"
check 'info finds everything in the folder' bash -c \
  '! "$@" info | sed -n "/^Data/,/^$/p" | grep -v "^Data\|^$\|  cache " | grep -vF "$0/share/nephoscope"' \
  "$folder" "${alone[@]}" "$work/link"
scene=$folder/share/nephoscope/scenes/400km.json
status=0
"${alone[@]}" "$work/link" render "$scene" --size 128x72 --quality low -o theirs.exr >out 2>err || status=$?
check "a picture, and not a word: $(cat out err)" test $status == 0 -a ! -s out -a ! -s err
check 'tables came with the folder' bash -c '! ls "$0"/.cache/nephoscope/atmosphere-* 2>/dev/null' "$work/home"
NEPHO_CACHE=$work/cache "$build/apps/nepho/nepho" render "$scene" --size 128x72 --quality low -o ours.exr 2>err
"$build/apps/nepho/nepho" compare theirs.exr ours.exr >compared
psnr=$(awk '$1 == "psnr_db" {print $2}' compared)
check "the picture is that of nepho: PSNR $psnr dB" awk -v p="$psnr" 'BEGIN {exit !(p == "inf" || p > 60)}'

: >ground.tif
check 'other rasters are refused' bash -c \
  '! "$@" render --terrain ground.tif -o no.png 2>err && [[ $(<err) == *"no GDAL"* ]]' _ "${alone[@]}" "$work/link"
mkdir kept && : >kept/mine
check 'a folder that is no package is not replaced' bash -c \
  '! "$0/cmake/package_folder.sh" "$1" kept 2>err && [[ -e kept/mine ]]' "$source" "$build"
[[ $failures == 0 ]] || { echo "$failures failures"; exit 1; }
