#!/usr/bin/env bash
# Facts about bad rasters of --terrain and --imagery: the picture is drawn from what remains, with one warning per
# source and exit status 0; with --strict, and of --weather, it is an error of status 3 and nothing is written.
# Usage: bad_ground_test.sh PATH-OF-NEPHO
set -euo pipefail
nepho=$1
work=$(mktemp -d)
servers=()
cleanup() {
  for server in "${servers[@]}"; do kill "$server" 2>/dev/null || true; done
  umount "$work/cache/blocks" 2>/dev/null || true
  rm -rf -- "$work"
}
trap cleanup EXIT
cd "$work"
export NEPHO_CACHE=$work/cache
failures=0
place=(--at 35.35,138.75 --height 9000 --pitch -60 --time 2026-06-20T03:00:00Z --quality low --size 32x18)
view=("${place[@]}" --coverage 0)

# draws WARNINGS "text that one of them has" arguments...: status 0, a picture, that many lines (or `some`) on standard
# error
draws() {
  local lines=$1 text=$2 status=0
  shift 2
  rm -f picture.*
  timeout 120 "$nepho" render "${view[@]}" "$@" -o picture.png >out 2>err </dev/null || status=$?
  if [[ $status == 0 && ($lines == some || $(wc -l <err) == "$lines") && $(<err) == *"$text"* && ! -s out && -s picture.png ]]; then
    echo "ok: $(head -c 200 err)"
  else
    echo "FAILED: $*: status $status, not 0 with $lines lines that have '$text'; standard error:"
    cat err
    failures=$((failures + 1))
  fi
}
# refuses "text" arguments...: with --strict status 3, one line, no picture
refuses() {
  local text=$1 status=0
  shift
  rm -f picture.*
  timeout 120 "$nepho" render "${view[@]}" "$@" --strict -o picture.png >out 2>err </dev/null || status=$?
  if [[ $status == 3 && $(<err) == *"error: "*"$text"* && ! -s out && ! -e picture.png ]]; then
    echo "ok: $(tail -n 1 err)"
  else
    echo "FAILED: --strict $*: status $status, not 3 with '$text'; standard error:"
    cat err
    failures=$((failures + 1))
  fi
}

# rejects "text" arguments...: what must not be left out: status 3, one line that has the text, no picture
rejects() {
  local text=$1 status=0
  shift
  rm -f picture.*
  timeout 120 "$nepho" render "${place[@]}" "$@" -o picture.png >out 2>err </dev/null || status=$?
  if [[ $status == 3 && $(wc -l <err) == 1 && $(<err) == *"error: "*"$text"* && ! -s out && ! -e picture.png ]]; then
    echo "ok: $(<err)"
  else
    echo "FAILED: $*: status $status, not 3 with one line that has '$text'; standard error:"
    cat err
    failures=$((failures + 1))
  fi
}

python3 - <<'PY'
import struct, zlib

def geotiff(name, west, north, step, side=1024, compressed=False, broken=()):
    """16-bit heights, one strip of 16 rows after the other; the strips `broken` hold rubbish."""
    strips, offsets, at = [], [], 8
    for s in range(side // 16):
        rows = b''.join(struct.pack(f'<{side}h', *[1000 + (x + s * 16 + y) % 500 for x in range(side)]) for y in range(16))
        data = zlib.compress(rows, 1) if compressed else rows
        if s in broken:
            data = b'rubbish ' * (len(data) // 8)
        offsets.append(at)
        strips.append(data)
        at += len(data)
    n = len(strips)
    after = at + n * 8
    tags = [(256, 3, 1, side), (257, 3, 1, side), (258, 3, 1, 16), (259, 3, 1, 8 if compressed else 1), (262, 3, 1, 1),
            (273, 4, n, at), (277, 3, 1, 1), (278, 3, 1, 16), (279, 4, n, at + n * 4), (339, 3, 1, 2),
            (33550, 12, 3, after), (33922, 12, 6, after + 24), (34735, 3, 16, after + 72)]
    keys = [1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326]
    with open(name, 'wb') as f:
        f.write(b'II*\0' + struct.pack('<I', after + 104))
        f.write(b''.join(strips))
        f.write(struct.pack(f'<{n}I', *offsets) + struct.pack(f'<{n}I', *[len(s) for s in strips]))
        f.write(struct.pack('<3d', step, step, 0) + struct.pack('<6d', 0, 0, 0, west, north, 0))
        f.write(struct.pack('<16H', *keys))
        f.write(struct.pack('<H', len(tags)))
        for tag, kind, count, value in tags:
            f.write(struct.pack('<HHII', tag, kind, count, value))
        f.write(struct.pack('<I', 0))

geotiff('good.tif', 138, 36, 0.001)
geotiff('far.tif', -70, 36, 0.001)
geotiff('beyond.tif', 138, 136, 0.001)
geotiff('holes.tif', 138, 36, 0.001, compressed=True, broken=range(20, 44))
PY
# The directory first, then pixels: what a download that was cut off looks like.
python3 - <<'PY'
data = open('good.tif', 'rb').read()
import struct
ifd = struct.unpack('<I', data[4:8])[0]
tail = data[ifd - 104 - 512:]          # strip arrays, georeference and directory
moved = 8
shift = moved - (ifd - 104 - 512)
tail = bytearray(tail)
strips = 64
offset = struct.unpack('<64I', tail[:256])
tail[:256] = struct.pack('<64I', *[o + len(tail) for o in offset])
at = 512 + 104
count = struct.unpack('<H', tail[at:at + 2])[0]
for i in range(count):
    p = at + 2 + 12 * i
    tag, kind, n, value = struct.unpack('<HHII', tail[p:p + 12])
    if tag in (273, 279, 33550, 33922, 34735):
        tail[p:p + 12] = struct.pack('<HHII', tag, kind, n, value + shift)
whole = b'II*\0' + struct.pack('<I', ifd + shift) + bytes(tail) + data[8:ifd - 104 - 512]
open('whole.tif', 'wb').write(whole)
open('cut.tif', 'wb').write(whole[:len(whole) // 2])
PY
: >empty.tif
printf 'ENVI\nsamples = 0\nlines = 0\nbands = 1\ndata type = 2\ninterleave = bsq\n' >zero.hdr
echo >zero
head -c 3000 /dev/urandom >noise.tif
printf 'ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\nnodata_value -1\n1 2\n3 4\n' >plain.asc
echo 'LOCAL_CS["nowhere"]' >plain.prj

"$nepho" render "${view[@]}" -o picture.png 2>/dev/null  # the tables of the atmosphere are in the cache from here on
draws 0 '' --terrain good.tif --terrain whole.tif
draws 1 'cut.tif' --terrain cut.tif --terrain good.tif
draws 1 'empty.tif: is an empty file; left out' --terrain empty.tif
draws 1 'zero: ' --terrain zero
draws 1 'noise.tif' --imagery noise.tif
draws 1 "plain.asc: its CRS 'nowhere'" --terrain plain.asc
draws 1 'far.tif: none of it is in view; it covers longitude -70' --terrain far.tif
draws 1 'beyond.tif' --terrain beyond.tif
draws 1 'holes.tif' --terrain holes.tif
draws 3 'far.tif' --terrain noise.tif --terrain empty.tif --terrain far.tif
refuses 'cut.tif' --terrain cut.tif
refuses 'plain.asc' --terrain plain.asc
refuses 'none of it is in view' --terrain far.tif
refuses 'holes.tif' --terrain holes.tif
draws 0 '' --terrain good.tif --strict

# What hangs: a file that refers to a pipe that nobody writes into, and a server that takes a request and never answers.
mkfifo pipe
cat >hangs.vrt <<'VRT'
<VRTDataset rasterXSize="64" rasterYSize="64"><SRS>EPSG:4326</SRS><GeoTransform>138, 0.01, 0, 36, 0, -0.01</GeoTransform>
<VRTRasterBand dataType="Int16" band="1"><SimpleSource><SourceFilename>pipe</SourceFilename><SourceBand>1</SourceBand>
<SourceProperties RasterXSize="64" RasterYSize="64" DataType="Int16" BlockXSize="64" BlockYSize="1"/>
<SrcRect xOff="0" yOff="0" xSize="64" ySize="64"/><DstRect xOff="0" yOff="0" xSize="64" ySize="64"/>
</SimpleSource></VRTRasterBand></VRTDataset>
VRT
echo '{"terrain": {"source_timeout_s": 2}}' >hasty.json
# GDAL keeps a lock while it opens what a VRT refers to: other rasters may not be opened any more.
draws some 'hangs.vrt: does not answer within 2 s; left out' hasty.json --terrain hangs.vrt
refuses 'hangs.vrt: does not answer' hasty.json --terrain hangs.vrt
rejects 'hangs.vrt: does not answer within 2 s' hasty.json --weather hangs.vrt
cat >server.py <<'PY'
import http.server, struct, sys, time, zlib
def png(r, g, b):
    def chunk(name, data): return struct.pack('>I', len(data)) + name + data + struct.pack('>I', zlib.crc32(name + data))
    row = b'\0' + bytes((r, g, b)) * 256
    return b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', 256, 256, 8, 2, 0, 0, 0)) + \
        chunk(b'IDAT', zlib.compress(row * 256)) + chunk(b'IEND', b'')
class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        if 'hang' in self.path: time.sleep(600)
        try: z, x, y = map(int, self.path[1:-4].split('/')[-3:])
        except ValueError: return self.send_error(404)
        if z >= 6 and x % 2: return self.send_error(500)
        data = png(120, 90, 60)
        self.send_response(200)
        self.send_header('Content-Type', 'image/png')
        self.send_header('Content-Length', str(len(data)))
        self.end_headers()
        self.wfile.write(data)
    do_HEAD = do_GET
    def log_message(self, *_): pass
server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Handler)
print(server.server_port, flush=True)
server.serve_forever()
PY
python3 server.py >port 2>/dev/null &
servers+=($!)
for _ in $(seq 100); do [[ -s port ]] && break; sleep 0.1; done
url=http://127.0.0.1:$(<port)
draws 1 'hang' hasty.json --terrain "/vsicurl/$url/hang.tif"
rejects '/hang.tif: does not answer within 2 s' hasty.json --weather "/vsicurl/$url/hang.tif"
rejects '/hang.tif: does not answer within 2 s' hasty.json --water-mask "/vsicurl/$url/hang.tif" --strict
draws 1 '127.0.0.1' hasty.json --imagery "$url/{z}/{x}/{y}.png"

# A disk without room for the cache: a warning, and the same picture. Needs a file system of its own.
rm -rf cache/blocks
mkdir cache/blocks
if mount -t tmpfs -o size=16k tmpfs cache/blocks 2>/dev/null; then
  draws 0 '' --terrain whole.tif --disk-cache 0
  cp picture.png before.png
  # The first block of the default picture takes long, so that it is to be kept.
  draws 1 'blocks of rasters are not kept on disk' --terrain whole.tif
  cmp before.png picture.png || failures=$((failures + 1))
  umount cache/blocks
else
  echo "no file system of its own could be mounted; the disk without room is not tried"
fi

echo "$failures failed"
((failures == 0))
