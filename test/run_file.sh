#!/bin/sh
# Runs the tests of one file in a program of googletest that has several.
#   run_file.sh PROGRAM FILE.cc [ARGUMENT OF GOOGLETEST ...]
set -eu
program=$1 file=$2
shift 2
filter=$(sed -nE 's/^TEST(_F|_P)?\((\w+).*/\2.*:*\/\2.*/p' "$file" | sort -u | paste -sd:)
[ -n "$filter" ] || { echo "run_file.sh: $file has no test" >&2; exit 1; }
exec "$program" "--gtest_filter=$filter" "$@"
