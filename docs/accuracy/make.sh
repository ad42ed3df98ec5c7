#!/usr/bin/env bash
# make.sh NEPHO
#
# Measures the fast path against the references in tests/images (make_references.sh there makes them) and writes the
# table of docs/accuracy.md between its two marker lines. Each light scene is drawn twice, with `--quality high` as it is
# and with clouds.multiple_scattering octaves, and compared where there are clouds. Needs python3.
# PAGE=FILE writes into another page, REFERENCES=FOLDER reads other references, DEVICE=NAME picks a device.
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: make.sh NEPHO" >&2; exit 2; }
nepho=$1
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
page=${PAGE:-$root/docs/accuracy.md}
references=${REFERENCES:-$root/tests/images}
device=()
[ -z "${DEVICE:-}" ] || device=(--device "$DEVICE")
mapfile -t names <"$root/tests/images/light_scenes.txt"
for name in "${names[@]}"; do
  [ -f "$references/$name.reference.exr" ] ||
    { echo "make.sh: $references/$name.reference.exr is missing; tests/images/make_references.sh makes it" >&2; exit 3; }
done
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT

# with_light METHOD SCENE.json: the scene with that multiple scattering, and no light shafts
with_light() {
  python3 - "$1" "$2" <<'PYTHON'
import json, sys
scene = json.load(open(sys.argv[2]))
scene["clouds"]["multiple_scattering"] = sys.argv[1]
scene["shafts"] = {"method": "none"}  # the references' air knows no shadows
print(json.dumps(scene))
PYTHON
}

for name in "${names[@]}"; do
  for method in cells octaves; do
    with_light $method "$root/data/scenes/$name.json" >"$work/scene.json"
    "$nepho" render "$work/scene.json" --quality high "${device[@]}" --aov cloud.transmittance -o "$work/picture.exr"
    "$nepho" compare "$work/picture.exr" "$references/$name.reference.exr" --mask cloud --json "$work/$name.$method.json"
  done
done

python3 - "$work" "$page" "${names[@]}" <<'PYTHON'
import json, pathlib, sys
work, page, names = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
BEGIN, END = "<!-- table: docs/accuracy/make.sh -->", "<!-- end of table -->"
METHODS = ["cells", "octaves"]
MEASURES = [("mean_relative_error", 100, "{:.1f}"), ("bias", 100, "{:+.1f}"), ("psnr_db", 1, "{:.1f}"),
            ("ssim", 1, "{:.2f}"), ("flip", 1, "{:.2f}")]

def cell(value, scale, form):
    return "-" if value is None else form.format(scale * value)

def mean(values):
    known = [v for v in values if v is not None]
    return sum(known) / len(known) if known else None

results = {(n, m): json.loads((work / f"{n}.{m}.json").read_text()) for n in names for m in METHODS}
heads = ["error %", "bias %", "PSNR dB", "SSIM", "FLIP"]
lines = ["| scene | cloud pixels | " + " | ".join(f"{m}: {h}" if h == heads[0] else h for m in METHODS for h in heads)
         + " | noise of reference % |",
         "|---|" + "---|" * (2 + len(METHODS) * len(heads))]
for n in names:
    cells = [cell(results[n, m][k], scale, form) for m in METHODS for k, scale, form in MEASURES]
    noise = results[n, METHODS[0]]["noise_of_b"]
    lines.append(f"| `{n}` | {results[n, METHODS[0]]['pixels']} | " + " | ".join(cells) + f" | {cell(noise, 100, '{:.1f}')} |")
cells = [cell(mean([results[n, m][k] for n in names]), scale, form) for m in METHODS for k, scale, form in MEASURES]
lines.append("| **mean** | | " + " | ".join(f"**{c}**" for c in cells) + " | |")

text = page.read_text()
if text.count(BEGIN) != 1 or text.count(END) != 1:
    sys.exit(f"make.sh: {page}: the marker lines '{BEGIN}' and '{END}' must be there once each")
before, rest = text.split(BEGIN)
after = rest.split(END)[1]
page.write_text(before + BEGIN + "\n" + "\n".join(lines) + "\n" + END + after)
PYTHON
echo "$page: table of ${#names[@]} scenes"
