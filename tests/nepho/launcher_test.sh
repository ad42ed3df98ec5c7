#!/usr/bin/env bash
# Facts about ./nepho, shown on a small project of the same layout in a temporary folder. Installs nothing.
set -euo pipefail
source_root=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../..
tree=$(mktemp -d)/with\ space
work=$(mktemp -d)
trap 'rm -rf -- "$(dirname -- "$tree")" "$work"' EXIT
export NEPHO_NO_INSTALL=1
failures=0

check() {  # check "fact" condition...
  local fact=$1
  shift
  if "$@"; then echo "ok: $fact"; else echo "FAILED: $fact ($*)"; failures=$((failures + 1)); fi
}
run() {  # run command...: fills $out, $err, $status
  status=0
  "$@" >"$work/out" 2>"$work/err" </dev/null || status=$?
  out=$(<"$work/out")
  err=$(<"$work/err")
}

mkdir -p "$tree/src" "$tree/apps/nepho" "$tree/cmake" "$tree/shaders" "$tree/tests"
cp "$source_root/nepho" "$source_root/CMakePresets.json" "$tree/"
cat >"$tree/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(small LANGUAGES CXX)
enable_testing()
add_subdirectory(apps/nepho)
foreach(module a b)
  if(EXISTS ${CMAKE_SOURCE_DIR}/src/${module}/CMakeLists.txt)
    add_subdirectory(src/${module})
  endif()
endforeach()
add_test(NAME passes COMMAND ${CMAKE_COMMAND} -E true)
END
cat >"$tree/apps/nepho/CMakeLists.txt" <<'END'
add_executable(nepho main.cpp)
END
program() {
  cat >"$tree/apps/nepho/main.cpp" <<END
#include <cstdio>
#include <unistd.h>
int main(int argc, char** argv) {
  char cwd[4096];
  std::printf("%s|%s", "$1", getcwd(cwd, sizeof cwd) ? cwd : "");
  for (int i = 1; i < argc; ++i) std::printf("|%s", argv[i]);
  for (int c; (c = std::getchar()) != EOF;) std::putchar(c);
  return 7;
}
END
}

program one
cd "$work"
run "$tree/nepho" a 'b c'
check "standard output and arguments are the program's, from any folder" test "$out" = "one|$work|a|b c"
check "the exit status is the program's" test "$status" = 7
check "the first start says on standard error that it builds" grep -q '^nepho: building' "$work/err"

ln -s "$tree/nepho" "$work/link"
run ./link x
check "a second start, through a symbolic link, says nothing" test "$err" = ""
check "a symbolic link finds its sources" test "$out" = "one|$work|x"
check "standard input reaches the program" test "$(printf piped | "$tree/nepho" || true)" = "one|${work}piped"

program two
run "$tree/nepho"
check "a changed source is rebuilt" test "$out" = "two|$work"

mkdir -p "$tree/src/a"
echo 'target_compile_definitions(nepho PRIVATE A)' >"$tree/src/a/CMakeLists.txt"
run "$tree/nepho"
check "a module that appears is configured" grep -q '^nepho: configuring' "$work/err"
rm -r "$tree/src/a"
run "$tree/nepho"
check "a module that goes is configured" grep -q '^nepho: configuring' "$work/err"
check "the program still runs after that" test "$out" = "two|$work"

echo 'this is no C++' >>"$tree/apps/nepho/main.cpp"
run "$tree/nepho"
check "a build failure is exit status 5" test "$status" = 5
check "a build failure shows the compiler's words" grep -q 'main.cpp:.*error' "$work/err"
check "a build failure leaves standard output empty" test "$out" = ""
check "a build failure ends with one line that says so" test "$(tail -n 1 "$work/err")" = \
  "nepho: error: the build failed (see above)"

program three
for i in 1 2 3; do "$tree/nepho" >"$work/out$i" 2>"$work/err$i" & done
wait
for i in 1 2 3; do check "of three starts at once, number $i runs the new program" test "$(<"$work/out$i")" = "three|$work"; done
check "of three starts at once, one builds" test "$(cat "$work"/err? | grep -c '^nepho: building')" = 1

run "$tree/nepho" test -N
check "'test' passes its arguments to ctest" test "$status" = 0
check "'test' lists the suite" grep -q 'Total Tests: 1' "$work/out"
echo 'add_test(NAME fails COMMAND ${CMAKE_COMMAND} -E false)' >>"$tree/CMakeLists.txt"
run "$tree/nepho" test
check "'test' passes on the failure of a test" test "$status" = 8

mv "$tree" "$tree.moved"
run "$tree.moved/nepho"
check "a copied or moved tree starts afresh" test "$out" = "three|$work"
mv "$tree.moved" "$tree"

# Packages: stand-ins for dpkg-query, apt-get and sudo.
mkdir "$work/bin"
printf '#!/bin/sh\necho "installed cmake"\n' >"$work/bin/dpkg-query"
printf '#!/bin/sh\necho "$@" >>"%s/apt.log"\nexit 100\n' "$work" >"$work/bin/apt-get"
printf '#!/bin/sh\nexit 1\n' >"$work/bin/sudo"
chmod +x "$work/bin/"*
rm -f "$tree/build/release/nepho.stamp"
PATH=$work/bin:$PATH run "$tree/nepho"
check "a package that may not be installed is exit status 5" test "$status" = 5
check "it is named with the command that installs it" grep -q 'apt-get install --no-install-recommends ninja-build' "$work/err"
check "an installed package is not named" test "${err/recommends cmake/}" = "$err"
check "nothing was installed" test ! -e "$work/apt.log"
if ((EUID == 0)); then
  NEPHO_NO_INSTALL='' PATH=$work/bin:$PATH run "$tree/nepho"
  check "a failing apt-get is exit status 5" test "$status" = 5
  check "apt-get was asked for missing packages without recommended ones" \
    grep -q 'install --no-install-recommends ninja-build' "$work/apt.log"
  check "apt-get update is tried before giving up" grep -q 'update$' "$work/apt.log"
  check "the last line says what could not be installed" grep -q '^nepho: error: apt-get .* ninja-build' "$work/err"
fi

run "$tree/nepho"
best=99999
for _ in 1 2 3 4 5; do
  began=$(date +%s%N)
  "$tree/nepho" >"$work/out" 2>&1 </dev/null || true
  took=$((($(date +%s%N) - began) / 1000000))
  ((took < best)) && best=$took
done
echo "a start with nothing to build takes $best ms"
check "a start with nothing to build adds less than 200 ms" test "$best" -lt 200

echo "$failures failed"
((failures == 0))
