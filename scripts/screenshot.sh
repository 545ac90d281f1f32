#!/usr/bin/env bash
# Calibrates a recording under a virtual display and writes what RViz shows at the end.
#   screenshot.sh BAG RIG [PICTURE]      PICTURE: default docs/rviz.png
# Needs a build (scripts/demo.sh or scripts/test.sh made one). MLIC_BUILD: build directory.
set -euo pipefail
. "$(dirname "$0")/environment.sh"

[ $# -eq 2 ] || [ $# -eq 3 ] || { sed -n '2,4p' "$0" >&2; exit 1; }
bag=$(realpath -- "$1"); rig=$(realpath -- "$2"); picture=$(realpath -m -- "${3:-$repository/docs/rviz.png}")
require_programs Xvfb import rviz
source_workspace

work=$(mktemp -d)
launch=""
cleanup() {
  if [ -n "$launch" ]; then kill -INT "$launch" 2>/dev/null && wait "$launch" || true; fi
  stop_virtual_display
  rm -rf "$work"
}
start_virtual_display
trap cleanup EXIT
export ROS_HOME=$work/ros MLIC_STATUS_FILE=$work/status

port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
# A job in the background ignores SIGINT, by which roslaunch is to end; so it is started with SIGINT as it was.
/usr/bin/python3 -c 'import os, signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)
os.execvp(sys.argv[1], sys.argv[1:])' roslaunch -p "$port" mlic calibrate.launch rig:="$rig" bag:="$bag" \
  output:="$work/calibration" rviz:=true >"$work/launch.log" 2>&1 &
launch=$!
while [ ! -s "$work/status" ]; do
  kill -0 "$launch" 2>/dev/null || { tail -20 "$work/launch.log" >&2; echo "screenshot.sh: the launch ended early" >&2; exit 3; }
  sleep 1
done
# Software rendering needs some seconds for the last messages.
sleep "${MLIC_SCREENSHOT_DELAY:-10}"
mkdir -p "$(dirname "$picture")"
import -window root "$picture"
status=$(head -n 1 "$work/status")
echo "screenshot.sh: $picture (calibrate ended with $status)"
exit "$status"
