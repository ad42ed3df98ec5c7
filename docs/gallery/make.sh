#!/usr/bin/env bash
# Remakes the pictures of README.md and docs/sky_gallery.md with the commands under them. Needs the elevation rasters: make.sh DEM_FOLDER
set -euo pipefail
dem=$(realpath "${1:?usage: docs/gallery/make.sh DEM_FOLDER}")
cd "$(dirname "$0")/../.."
# Every command line there that writes a picture of docs/gallery, with DEM in place of its folder.
grep -o '`./nepho render --[^`]*-o [a-z0-9_]*\.png`' README.md docs/sky_gallery.md | sed 's/^[^:]*://' | tr -d '`' | while read -r line; do
  line=${line//DEM\//$dem/}
  line=${line/ -o / -o docs/gallery/}
  echo "$line"
  $line
done
