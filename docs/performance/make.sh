#!/usr/bin/env bash
# make.sh NEPHO [FRAMES]
#
# Measures what a frame costs against pixels, layers, coverage and height, and with each preset, and writes the tables of
# docs/performance.md between their marker lines. FRAMES (default 8) are measured of each case, after as many. Needs python3
# and an idle machine.
# PAGE=FILE writes into another page, DEVICE=NAME picks a device, QUALITY=NAME another preset for the tables of scaling
# (default high), SIZE=WxH another size (default 640x360), ONLY="pixels presets..." some of the tables.
set -euo pipefail
[ $# -ge 1 ] || { echo "usage: make.sh NEPHO [FRAMES]" >&2; exit 2; }
here=$(cd "$(dirname "$0")" && pwd)
exec python3 - "$1" "${2:-8}" "$here/../.." <<'PYTHON'
import json, os, pathlib, subprocess, sys, tempfile

nepho, frames, root = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
page = pathlib.Path(os.environ.get("PAGE", root / "docs/performance.md"))
quality, size = os.environ.get("QUALITY", "high"), os.environ.get("SIZE", "640x360")
ground = json.loads((root / "data/scenes/ground.json").read_text())
device = ["--device", os.environ["DEVICE"]] if "DEVICE" in os.environ else []


def bench(scene, size=size, quality=quality, upscale=("1", "16")):
    """Figures of a scene, one object for each upscale."""
    with tempfile.TemporaryDirectory() as folder:
        name, out = scene, pathlib.Path(folder) / "out.json"
        if not isinstance(scene, str):
            name = str(pathlib.Path(folder) / "scene.json")
            pathlib.Path(name).write_text(json.dumps(scene))
        command = [nepho, "bench", "--scene", name, "--size", size, "--quality", quality, "--frames", frames, "--warm-up",
                   frames, "--json", str(out), *device]
        for u in upscale:
            command += ["--upscale", u]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text())


def of_pass(result, *names):
    return sum(p["median_ms"] for p in result["passes"] if p["name"] in names)


def ms(value):
    return f"{value:.2f}" if value < 10 else f"{value:.0f}"


def row(what, results):
    every, few = results
    return (f"| {what} | {ms(every['frame_median_ms'])} | {ms(every['gpu_median_ms'])} | {ms(of_pass(every, 'clouds.march'))} | "
            f"{ms(few['frame_median_ms'])} | {ms(few['gpu_median_ms'])} | {ms(of_pass(few, 'clouds.march'))} |")


HEAD = "| {} | every pixel: frame, ms | passes | march | upscale 16: frame, ms | passes | march |\n|---|---|---|---|---|---|---|"


def changed(**clouds):
    scene = json.loads(json.dumps(ground))
    scene["clouds"].update(clouds)
    return scene


def pixels():
    rows = [row(f"{w} x {h}", bench(ground, f"{w}x{h}")) for w, h in ((160, 90), (320, 180), (640, 360), (1280, 720))]
    return [HEAD.format(f"`ground`, `{quality}`"), *rows]


def layers():
    kinds = ["cumulus", "cirrus", "altocumulus", "stratocumulus"]
    rows = [row("none", bench(changed(layers=[])))]
    for n in range(1, 5):
        rows.append(row(", ".join(kinds[:n]), bench(changed(layers=[{"genus": k} for k in kinds[:n]]))))
    return [HEAD.format(f"layers, `ground`, {size} `{quality}`"), *rows]


def coverage():
    rows = [row(f"{c}", bench(changed(coverage=c))) for c in (0, 0.1, 0.25, 0.5, 0.75, 1)]
    return [HEAD.format(f"coverage, `ground`, {size} `{quality}`"), *rows]


def height():
    rows = []
    for m, pitch in ((2, 4), (500, 4), (1500, 0), (4000, -10), (10000, -15), (100000, -40), (400000, -55), (36000000, -90)):
        scene = json.loads(json.dumps(ground))
        scene["clouds"] = {}  # the Earth's weather: even clouds are a carpet from far away
        scene["camera"].pop("agl_m")
        scene["camera"].update({"height_m": m if m > 1000 else 100 + m, "pitch_deg": pitch})
        if m > 1000000:
            scene["camera"]["fov_deg"] = 20
        rows.append(row(f"{m / 1000:g} km", bench(scene)))
    return [HEAD.format(f"height, the Earth's weather, {size} `{quality}`"), *rows]


def presets():
    rows = []
    for name in ("low", "medium", "high", "ultra"):
        few, every = bench("ground", "640x360", name, ("16", "1"))
        large = bench("ground", "1280x720", name, ("16",))[0]
        rows.append(f"| {name} | {ms(every['frame_median_ms'])} | {ms(few['frame_median_ms'])} | {ms(large['frame_median_ms'])} | "
                    f"{few['startup_ms'] / 1000:.1f} + {few['first_frame_ms'] / 1000:.1f} s |")
    device_name = few["device"]
    return [f"| {device_name}, `ground`, ms a frame | 640 x 360, every pixel | upscale 16 | 1280 x 720, upscale 16 | start and first "
            "picture (tables in the cache) |\n|---|---|---|---|---|", *rows]


tables = {"presets": presets, "pixels": pixels, "layers": layers, "coverage": coverage, "height": height}
text = page.read_text()
for name in os.environ.get("ONLY", " ".join(tables)).split():
    begin, end = f"<!-- {name}: docs/performance/make.sh -->", f"<!-- end of {name} -->"
    if begin not in text or end not in text:
        sys.exit(f"make.sh: {page} lacks the lines {begin} and {end}")
    lines = "\n".join(tables[name]())
    before, rest = text.split(begin)
    text = before + begin + "\n" + lines + "\n" + end + rest.split(end)[1]
    page.write_text(text)
    print(lines, flush=True)
PYTHON
