#!/bin/sh
# relocate.sh DIR NAME=PROGRAM...: puts stripped programs into DIR/bin with the libraries that they need, and a launcher
# DIR/NAME for each that finds them wherever the folder lies.
#
# glibc is the machine's own, and must not be older than here. Libraries that Vulkan drivers load too lie in lib/shared,
# and are used only where the machine's own are missing or older: two of one name cannot be loaded together, and a
# driver may need its machine's.
set -eu
[ $# -ge 2 ] || { echo "usage: relocate.sh DIR NAME=PROGRAM..." >&2; exit 2; }
dir=$1
shift
mkdir -p "$dir/bin" "$dir/lib"
for pair; do
  name=${pair%%=*} program=${pair#*=}
  strip -o "$dir/bin/$name" "$program"
  ldd "$program" | awk '$2 == "=>" && $3 ~ /^\// {print $3}' | while read -r library; do
    soname=$(basename "$library")
    case $soname in
      libgdal.*) echo "relocate.sh: $name needs GDAL, whose libraries are too many to carry" >&2; exit 3 ;;
      libc.so.* | libm.so.* | libdl.so.* | librt.so.* | libpthread.so.*) ;;
      libstdc++.so.* | libgcc_s.so.* | libvulkan.so.* | libz.so.* | libzstd.so.* | libexpat.so.*)
        mkdir -p "$dir/lib/shared/$soname"
        cp -L "$library" "$dir/lib/shared/$soname/"
        basename "$(readlink -f "$library")" >"$dir/lib/shared/$soname/version" ;;  # libz.so.1.2.13
      *) cp -L "$library" "$dir/lib/" ;;
    esac
  done
  cat >"$dir/$name" <<'RUN'
#!/bin/sh
# Starts bin/ of this folder with its libraries (made by cmake/relocate.sh).
self=$0
while [ -L "$self" ]; do
  link=$(readlink "$self")
  case $link in /*) self=$link ;; *) self=$(dirname "$self")/$link ;; esac
done
here=$(cd "$(dirname "$self")" && pwd)
libraries=$here/lib
known=$({ ldconfig -p || /sbin/ldconfig -p; } 2>/dev/null | sed -n 's/^[[:space:]]*\([^ ]*\) (.*x86-64.*) => /\1 /p')
for own in "$here"/lib/shared/*; do
  [ -d "$own" ] || continue
  name=${own##*/}
  theirs=$(echo "$known" | awk -v name="$name" '$1 == name {print $2; exit}')
  if [ -n "$theirs" ]; then
    version=$(basename "$(readlink -f "$theirs")")
    newest=$({ cat "$own/version"; echo "$version"; } | sort -V | tail -n 1)
    [ "$newest" != "$version" ] || continue
  fi
  libraries=$libraries:$own
done
export LD_LIBRARY_PATH="$libraries${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}"
exec "$here/bin/$(basename "$self")" "$@"
RUN
  chmod +x "$dir/$name"
done
