#!/usr/bin/env bash
# Remakes the pictures of README.md, docs/sky_gallery.md and docs/cloud_gallery.md with the commands under them. Needs the elevation rasters and
# the satellite's clouds: make.sh DEM_FOLDER MAP_FOLDER [PATTERN]; with a pattern only pictures whose name matches it.
set -euo pipefail
usage="usage: docs/gallery/make.sh DEM_FOLDER MAP_FOLDER [PATTERN]"
dem=$(realpath "${1:?$usage}")
maps=$(realpath "${2:?$usage}")
pattern=${3:-.}
cd "$(dirname "$0")/../.."
# Every command line there that writes a picture of docs/gallery, with DEM in place of its folder.
grep -o '`./nepho render --[^`]*-o [a-z0-9_]*\.png`' README.md docs/sky_gallery.md docs/cloud_gallery.md | sed 's/^[^:]*://' | tr -d '`' | while read -r line; do
  [[ ${line##* } =~ $pattern ]] || continue
  line=${line//DEM\//$dem/}
  line=${line//MAPS\//$maps/}
  line=${line/ -o / -o docs/gallery/}
  echo "$line"
  $line
done
