#!/usr/bin/env bash
# Installs what is needed, builds, and runs every check: unit tests, rostests, layers, formatting, end to end.
#   test.sh [ARGUMENT OF CTEST ...]      e.g. test.sh -LE slow
# MLIC_BUILD: build directory; MLIC_JOBS: compile jobs; MLIC_TEST_JOBS: tests at a time. Exit status: 0 when all pass.
set -euo pipefail
. "$(dirname "$0")/environment.sh"

"$repository/scripts/install_dependencies.sh" --with-learned
require_host_name
build_mlic -DBUILD_TESTING=ON -DMLIC_WITH_ROS=ON
cd "$build"
# ctest ends with its own summary ("N% tests passed, M tests failed out of K"); its exit status is ours.
exec ctest --output-on-failure --no-tests=error -j "${MLIC_TEST_JOBS:-2}" "$@"
