#!/usr/bin/env python3
"""Draws the horizon from 60 altitudes, 2 m to 40,000 km, as strips side by side: sky_sweep.png, beside this script.

Rings, seams and jumps between ways of computing the air would show as steps. Needs only ./nepho.
usage: docs/gallery/altitude_sweep.py [TIME [HEADING [EV100]]]
"""
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH, HEIGHT, COUNT = 20, 120, 60
EARTH_RADIUS_M = 6371000.0


def read_png(path):
    """Rows of an 8-bit RGB PNG."""
    data = path.read_bytes()
    at, body = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        if kind == b"IHDR":
            width, height = struct.unpack_from(">II", data, at + 8)
        if kind == b"IDAT":
            body += data[at + 8:at + 8 + size]
        at += size + 12
    raw, rows, before = zlib.decompress(body), [], bytes(3 * width)
    for y in range(height):
        filter_type = raw[y * (3 * width + 1)]
        line = bytearray(raw[y * (3 * width + 1) + 1:(y + 1) * (3 * width + 1)])
        for i in range(len(line)):
            left = line[i - 3] if i >= 3 else 0
            up = before[i]
            corner = before[i - 3] if i >= 3 else 0
            guess = left + up - corner
            paeth = min((left, up, corner), key=lambda v: abs(guess - v))
            line[i] = (line[i] + (0, left, up, (left + up) // 2, paeth)[filter_type]) & 255
        before = bytes(line)
        rows.append(before)
    return rows


def write_png(path, rows):
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    header = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)
    body = zlib.compress(b"".join(b"\0" + r for r in rows), 9)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", body) + chunk(b"IEND", b""))


def main():
    time, heading, ev = (sys.argv[1:] + ["2026-06-20T22:00:00Z", "270", "14.5"][len(sys.argv) - 1:])[:3]
    strips = []
    with tempfile.TemporaryDirectory() as folder:
        for i in range(COUNT):
            height_m = 2.0 * (4e7 / 2.0) ** (i / (COUNT - 1))
            dip_deg = math.degrees(math.acos(EARTH_RADIUS_M / (EARTH_RADIUS_M + height_m)))
            disc_deg = math.degrees(math.asin(EARTH_RADIUS_M / (EARTH_RADIUS_M + height_m)))
            fov_deg = min(8.0, max(2.5, 0.2 * disc_deg))
            picture = pathlib.Path(folder) / f"{i}.png"
            subprocess.run([ROOT / "nepho", "render", "--at", "10,-150", "--height", f"{height_m:.3f}", "--heading", heading,
                            "--pitch", f"{-dip_deg:.4f}", "--fov", f"{fov_deg:.3f}", "--coverage", "0", "--size",
                            f"{WIDTH}x{HEIGHT}", "--time", time, "--exposure", ev, "-o", picture], check=True)
            strips.append(read_png(picture))
    rows = [b"".join(strip[y] for strip in strips) for y in range(HEIGHT)]
    write_png(pathlib.Path(__file__).with_name("sky_sweep.png"), rows)


main()
