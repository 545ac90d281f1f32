#!/usr/bin/env bash
# Fails on whatever catkin_lint finds; skipped (status 77) where it is not installed.
#   check_catkin_lint.sh REPOSITORY
set -euo pipefail
if ! command -v catkin_lint >/dev/null; then
  echo "check_catkin_lint.sh: skipped, catkin_lint is not installed"
  exit 77
fi
# Offline: the names of ROS packages are known without a copy of rosdep's database.
exec catkin_lint --offline --strict "$1"
