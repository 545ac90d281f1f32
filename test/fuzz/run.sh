#!/usr/bin/env bash
# libFuzzer over all that MLIC reads of others, with AddressSanitizer and UndefinedBehaviorSanitizer.
#   run.sh EXECUTIONS [TARGET...]     default: all targets; one line each, findings under build-fuzz/findings
# Needs Clang 14 with libFuzzer (clang-14, libclang-rt-14-dev). MLIC_FUZZ_SANITIZERS=none: without the two, faster.
# Exit status: 0 without a finding.
set -euo pipefail
cd "$(dirname "$0")/../.."
. scripts/environment.sh
[ $# -ge 1 ] || { sed -n '3,5p' "$0" >&2; exit 1; }
executions=$1
shift
build=$repository/build-fuzz
flags="-O1 -g1 -fsanitize=fuzzer-no-link"
if [ "${MLIC_FUZZ_SANITIZERS:-}" = none ]; then
  build=$repository/build-fuzz-plain
else
  flags+=" -fsanitize=address,undefined -fno-sanitize=null,alignment,object-size,vptr,function -fno-sanitize-recover=all"
fi
mkdir -p "$build/findings"
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DCMAKE_CXX_COMPILER=clang++-14 \
  -DCMAKE_CXX_FLAGS_DEBUG="$flags" -DMLIC_WITH_FUZZERS=ON >"$build/configure.log" || { cat "$build/configure.log"; exit 1; }
ninja -C "$build" fuzzers >"$build/build.log" || { tail -n 40 "$build/build.log"; exit 1; }
targets=("$@")
if [ ${#targets[@]} -eq 0 ]; then mapfile -t targets < <(ls test/fuzz/corpus); fi
failed=()
for target in "${targets[@]}"; do
  log=$build/$target.log
  mkdir -p "$build/corpus/$target"
  # Files are read from memory; what is found stays, as do the inputs that reached new code.
  TMPDIR=/dev/shm ASAN_OPTIONS=detect_leaks=0 "$build/fuzz/fuzz_$target" -runs="$executions" -seed=1 -max_len=4096 \
    -rss_limit_mb=4096 -malloc_limit_mb=1024 -timeout=10 -print_final_stats=1 -artifact_prefix="$build/findings/$target-" \
    "$build/corpus/$target" "test/fuzz/corpus/$target" >"$log" 2>&1 || failed+=("$target")
  echo "$target: $(grep -o 'number_of_executed_units: [0-9]*' "$log" | tail -1 | grep -o '[0-9]*$' || echo 0) executions, $(
    grep -o 'cov: [0-9]*' "$log" | tail -1 || true)"
done
if [ ${#failed[@]} -gt 0 ]; then
  echo "run.sh: findings in $build/findings: ${failed[*]}" >&2
  exit 1
fi
