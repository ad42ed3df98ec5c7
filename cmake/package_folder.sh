#!/bin/sh
# package_folder.sh BUILD_DIR OUT_DIR: one relocatable folder of nepho_portable with its libraries, scenes and the baked
# Earth, geoid and tables, for another x86-64 Linux machine with a Vulkan driver (docs/packaging.md). Replaces OUT_DIR.
set -eu
[ $# -eq 2 ] || { echo "usage: package_folder.sh BUILD_DIR OUT_DIR" >&2; exit 2; }
build=$1
source=$(cd "$(dirname "$0")/.." && pwd)
mkdir -p "$(dirname "$2")"
out=$(cd "$(dirname "$2")" && pwd)/$(basename "$2")
[ ! -e "$out" ] || [ -x "$out/bin/nepho" ] || { echo "package_folder.sh: $out is there and no package; name another" >&2; exit 2; }
new=$out.new.$$
trap 'rm -rf "$new"' EXIT
mkdir -p "$new/share/nephoscope" "$new/cache"

"$source/cmake/relocate.sh" "$new" "nepho=$build/apps/nepho/nepho_portable"
cp "$source/LICENSE" "$new/"
cp -r "$source/data/." "$new/share/nephoscope/"
"$build/apps/nepho/nepho_bake" "$new/share/nephoscope/earth"

# Tables: what takes a first start longest, for any device. Others are larger and quicker made.
if env -u NEPHO_DATA NEPHO_CACHE="$new/cache" "$new/nepho" render "$new/share/nephoscope/scenes/ground.json" --size 16x9 \
    --quality low -o "$new/cache/first.png" >"$new/first.log" 2>&1; then
  mkdir "$new/share/nephoscope/tables"
  for table in atmosphere-* clouds.blue.bin clouds.shape.bin clouds.detail.bin clouds.turbulence.bin; do
    cp "$new/cache/"$table "$new/share/nephoscope/tables/"
  done
else
  cat "$new/first.log" >&2
  echo "package_folder.sh: no picture could be drawn here, so the folder has no tables; its first start makes them" >&2
fi
rm -rf "$new/cache" "$new/first.log"

bytes=$(du -sb "$new" | cut -f1)
[ "$bytes" -lt 64000000 ] || { echo "package_folder.sh: $bytes bytes are too many (64 MB)" >&2; exit 5; }
rm -rf "$out"
mv "$new" "$out"
echo "$out: $((bytes / 1000000)) MB; start it with $out/nepho" >&2
