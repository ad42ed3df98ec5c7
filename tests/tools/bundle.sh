#!/bin/sh
# bundle.sh BUILD_DIR OUT_DIR [TEST | --program NAME]...
#
# A relocatable copy of test programs and of programs, for a machine that has a Vulkan driver and none of our libraries or sources:
#   OUT_DIR/run.sh TEST [doctest arguments]      e.g. OUT_DIR/run.sh test_atmosphere_gpu -s
#   OUT_DIR/run.sh NAME [arguments]              e.g. OUT_DIR/run.sh nepho_portable render OUT_DIR/data/scenes/cirrus.json -o cirrus.png
# Without names: every test program of BUILD_DIR that does not need GDAL. Libraries as cmake/relocate.sh has them. With a
# program, and where nepho_bake is built, the default Earth goes along. `./nepho package` is for users (docs/packaging.md).
set -eu
[ $# -ge 2 ] || { echo "usage: bundle.sh BUILD_DIR OUT_DIR [TEST | --program NAME]..." >&2; exit 2; }
build=$1 out=$2
shift 2
source=$(cd "$(dirname "$0")/../.." && pwd)

if [ $# -eq 0 ]; then
  for program in "$build"/tests/*/test_*; do
    [ -f "$program" ] && [ -x "$program" ] || continue
    ldd "$program" | grep -q libgdal || set -- "$@" "$(basename "$program")"
  done
fi
[ $# -gt 0 ] || { echo "bundle.sh: no test programs in $build/tests; build some first" >&2; exit 3; }

rm -rf "$out"
mkdir -p "$out/oracles"
has_program= where=$build/tests
for name; do
  shift
  if [ "$name" = --program ]; then
    has_program=yes where=$build/apps
    continue
  fi
  program=$(find "$where" -name "$name" -type f -perm -u+x | head -n 1)
  [ -n "$program" ] || { echo "bundle.sh: $name is not in $where; build it first" >&2; exit 3; }
  set -- "$@" "$name=$program"
  where=$build/tests
done
"$source/cmake/relocate.sh" "$out" "$@"
cp "$source"/tests/oracles/*.csv "$out/oracles/"
cp -r "$source/data" "$out/data"
bake=$build/apps/nepho/nepho_bake
if [ -n "$has_program" ] && [ -x "$bake" ]; then
  "$bake" "$out/data/earth"
elif [ -f /usr/share/proj/egm96_15.gtx ]; then
  mkdir "$out/data/earth"
  cp /usr/share/proj/egm96_15.gtx "$out/data/earth/"
fi

cat > "$out/run.sh" <<'RUN'
#!/bin/sh
# run.sh PROGRAM [arguments]: made by tests/tools/bundle.sh.
here=$(cd "$(dirname "$0")" && pwd)
[ $# -ge 1 ] || { echo "usage: run.sh PROGRAM [arguments]; programs:" $(ls "$here/bin") >&2; exit 2; }
test=$1
shift
export NEPHO_TEST_ORACLES="$here/oracles" NEPHO_DATA="$here/data" NEPHO_TEST_NO_VALIDATION=1
exec "$here/$test" "$@"
RUN
chmod +x "$out/run.sh"
du -sh "$out" | awk '{print "bundle of", $1}' >&2
