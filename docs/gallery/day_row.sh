#!/usr/bin/env bash
# Draws day_ground.png and day_orbit.png beside this script: broken cumulus and cirrus from noon to deep night, eight pictures in
# a row each. The last but one has neither sun nor moon, the last a gibbous moon behind the camera. Needs ImageMagick; takes
# some 10 minutes on a CPU.
# usage: docs/gallery/day_row.sh [OPTION OF nepho render]...
set -euo pipefail
cd "$(dirname "$0")/../.."
# 2026-09-30, UTC. On the ground the Gobi (no city lights), the sun in degrees: 45, 23, 5, 0, -2, -6, -18, -49, the moon at 37.
# From orbit over Japan: 51, 24, 5, 0, -2, -6, -24, -56, the moon at 39.
ground=(05:00 08:30 10:12 10:40 10:50 11:12 12:20 16:00)
orbit=(03:00 06:30 08:05 08:30 08:40 09:00 10:30 14:00)
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
for view in ground orbit; do
  declare -n times=$view
  row=()
  for time in "${times[@]}"; do
    row+=("$folder/$view-$time.png")
    ${NEPHO:-./nepho} render "data/scenes/day_$view.json" --time "2026-09-30T${time}Z" --quality medium "$@" -o "${row[-1]}"
  done
  convert "${row[@]}" -bordercolor black -border 1 +append +repage -strip "docs/gallery/day_$view.png"
done
