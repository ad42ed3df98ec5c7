#!/usr/bin/env bash
# make_references.sh PROGRAM [NAME...]
#
# Renders the references of the light scenes (light_scenes.txt; or those named) with the path tracer, to 2 % noise, as
# NAME.reference.exr beside this script. PROGRAM is nepho or nepho_portable, or a bundle's `run.sh nepho_portable`, quoted.
# Each holds what comparisons need and no more: R G B, their variance, the number of paths, and the clouds' transmittance.
# NOISE=0.05 asks for another noise, OUT=FOLDER for another folder, DEVICE=NAME for a device.
set -euo pipefail
[ $# -ge 1 ] || { echo "usage: make_references.sh PROGRAM [NAME...]" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
scenes=${NEPHO_DATA:-$here/../../data}/scenes
out=${OUT:-$here}
read -ra program <<<"$1"
shift
[ $# -gt 0 ] || mapfile -t names <"$here/light_scenes.txt"
[ $# -eq 0 ] || names=("$@")
options=(--quality reference --noise "${NOISE:-0.02}" --aov variance,samples,cloud.transmittance)
[ -z "${DEVICE:-}" ] || options+=(--device "$DEVICE")

mkdir -p "$out"
for name in "${names[@]}"; do
  [ -f "$scenes/$name.json" ] || { echo "make_references.sh: $scenes/$name.json: no such scene" >&2; exit 3; }
done
for name in "${names[@]}"; do
  SECONDS=0
  "${program[@]}" render "$scenes/$name.json" "${options[@]}" -o "$out/$name.reference.exr"
  echo "$name: ${SECONDS} s, $(wc -c <"$out/$name.reference.exr") bytes"
done
