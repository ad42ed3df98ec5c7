#!/bin/sh
# bundle.sh BUILD_DIR OUT_DIR [TEST | --program NAME]...
#
# A relocatable copy of test programs and of programs, for a machine that has a Vulkan driver and none of our libraries or sources:
#   OUT_DIR/run.sh TEST [doctest arguments]      e.g. OUT_DIR/run.sh test_atmosphere_gpu -s
#   OUT_DIR/run.sh NAME [arguments]              e.g. OUT_DIR/run.sh nepho_portable render OUT_DIR/data/scenes/cirrus.json -o cirrus.png
# Without names: every test program of BUILD_DIR that does not need GDAL. The machine's C and C++ runtimes are used (glibc and
# libstdc++ must not be older than here), and its Vulkan loader where it has one.
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
mkdir -p "$out/bin" "$out/lib" "$out/loader" "$out/oracles"
while [ $# -gt 0 ]; do
  where=$build/tests
  if [ "$1" = --program ]; then
    where=$build/apps
    shift
    [ $# -gt 0 ] || { echo "bundle.sh: --program needs a name" >&2; exit 2; }
  fi
  test=$1
  shift
  program=$(find "$where" -name "$test" -type f -perm -u+x | head -n 1)
  [ -n "$program" ] || { echo "bundle.sh: $test is not in $where; build it first" >&2; exit 3; }
  strip -o "$out/bin/$test" "$program"
  ldd "$program" | awk '$2 == "=>" && $3 ~ /^\// {print $3}' | while read -r library; do
    case $(basename "$library") in
      libgdal.*) echo "bundle.sh: $test needs GDAL, whose libraries are too many to carry" >&2; exit 3 ;;
      libc.so.* | libm.so.* | libdl.so.* | librt.so.* | libpthread.so.* | libstdc++.so.* | libgcc_s.so.*) ;;
      libvulkan.so.*) cp -L "$library" "$out/loader/" ;;
      *) cp -L "$library" "$out/lib/" ;;
    esac
  done
done
cp "$source"/tests/oracles/*.csv "$out/oracles/"
cp -r "$source/data" "$out/data"
[ ! -f /usr/share/proj/egm96_15.gtx ] || { mkdir "$out/proj" && cp /usr/share/proj/egm96_15.gtx "$out/proj/"; }

cat > "$out/run.sh" <<'RUN'
#!/bin/sh
# run.sh PROGRAM [arguments]: made by tests/tools/bundle.sh.
here=$(cd "$(dirname "$0")" && pwd)
[ $# -ge 1 ] || { echo "usage: run.sh PROGRAM [arguments]; programs:" $(ls "$here/bin") >&2; exit 2; }
test=$1
shift
libraries=$here/lib
# The machine's own Vulkan loader, where it has one.
{ ldconfig -p 2>/dev/null || /sbin/ldconfig -p; } | grep -q libvulkan.so.1 || libraries=$libraries:$here/loader
export LD_LIBRARY_PATH="$libraries${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
export PROJ_DATA="${PROJ_DATA:+$PROJ_DATA:}$here/proj"
export NEPHO_TEST_ORACLES="$here/oracles" NEPHO_DATA="$here/data" NEPHO_TEST_NO_VALIDATION=1
exec "$here/bin/$test" "$@"
RUN
chmod +x "$out/run.sh"
du -sh "$out" | awk '{print "bundle of", $1}' >&2
