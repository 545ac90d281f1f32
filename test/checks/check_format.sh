#!/usr/bin/env bash
# Fails when a source file is not as clang-format 14 leaves it; other versions format otherwise, so without 14 the
# check is skipped (status 77).
#   check_format.sh REPOSITORY
set -euo pipefail
cd "$1"
formatter=""
for candidate in clang-format-14 clang-format; do
  if command -v "$candidate" >/dev/null && [[ "$("$candidate" --version)" == *"version 14."* ]]; then
    formatter=$candidate
    break
  fi
done
if [ -z "$formatter" ]; then
  echo "check_format.sh: skipped, clang-format 14 is not installed"
  exit 77
fi
find src test benchmark -type f \( -name '*.h' -o -name '*.cc' \) -print0 | sort -z |
  xargs -0 "$formatter" --dry-run -Werror
echo "check_format.sh: every source file is formatted"
