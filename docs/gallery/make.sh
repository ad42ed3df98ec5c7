#!/usr/bin/env bash
# Remakes the pictures of README.md and of the galleries of sky, clouds and ground with the commands under them. Needs the elevation rasters,
# the satellite's clouds and the pictures of the ground; with a pattern only pictures whose name matches it.
set -euo pipefail
usage="usage: docs/gallery/make.sh DEM_FOLDER MAP_FOLDER IMAGERY_FOLDER [PATTERN]"
dem=$(realpath "${1:?$usage}")
maps=$(realpath "${2:?$usage}")
imagery=$(realpath "${3:?$usage}")
pattern=${4:-.}
cd "$(dirname "$0")/../.."
# Every command line there that writes a picture of docs/gallery, with DEM, MAPS and IMAGERY in place of the folders.
grep -o '`./nepho render --[^`]*-o [a-z0-9_]*\.png`' README.md docs/{sky,cloud,ground}_gallery.md | sed 's/^[^:]*://' | tr -d '`' | while read -r line; do
  [[ ${line##* } =~ $pattern ]] || continue
  line=${line//DEM\//$dem/}
  line=${line//MAPS\//$maps/}
  line=${line//IMAGERY/$imagery}
  line=${line/ -o / -o docs/gallery/}
  echo "$line"
  $line
done
