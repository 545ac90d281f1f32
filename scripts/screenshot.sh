#!/usr/bin/env bash
# Calibrates a recording under a virtual display and writes what RViz shows at the end.
#   screenshot.sh BAG RIG [PICTURE]      PICTURE: default docs/rviz.png
# Needs a build (scripts/demo.sh or scripts/test.sh made one). MLIC_BUILD: build directory.
set -euo pipefail
. "$(dirname "$0")/environment.sh"

[ $# -eq 2 ] || [ $# -eq 3 ] || { sed -n '2,4p' "$0" >&2; exit 1; }
bag=$(realpath -- "$1"); rig=$(realpath -- "$2"); picture=$(realpath -m -- "${3:-$repository/docs/rviz.png}")
for program in Xvfb import rviz; do
  command -v "$program" >/dev/null || { echo "screenshot.sh: no $program: run scripts/install_dependencies.sh" >&2; exit 1; }
done
source_workspace

work=$(mktemp -d)
pids=()
cleanup() {
  for pid in ${pids[@]+"${pids[@]}"}; do kill -INT "$pid" 2>/dev/null || true; done
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap cleanup EXIT

# Xvfb finds a free display by itself and writes its number.
Xvfb -displayfd 3 -screen 0 1600x1000x24 +extension GLX 3>"$work/display" >"$work/xvfb.log" 2>&1 &
xvfb=$!
for _ in $(seq 100); do [ -s "$work/display" ] && break; sleep 0.1; done
[ -s "$work/display" ] || { cat "$work/xvfb.log" >&2; echo "screenshot.sh: Xvfb did not start" >&2; exit 1; }
DISPLAY=:$(cat "$work/display")
mkdir -m 700 "$work/runtime"
export DISPLAY LIBGL_ALWAYS_SOFTWARE=1 XDG_RUNTIME_DIR=$work/runtime ROS_HOME=$work/ros QT_X11_NO_MITSHM=1
export MLIC_STATUS_FILE=$work/status

port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("", 0)); print(s.getsockname()[1])')
# A job in the background ignores SIGINT, by which roslaunch is to end; so it is started with SIGINT as it was.
/usr/bin/python3 -c 'import os, signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler)
os.execvp(sys.argv[1], sys.argv[1:])' roslaunch -p "$port" mlic calibrate.launch rig:="$rig" bag:="$bag" \
  output:="$work/calibration" rviz:=true >"$work/launch.log" 2>&1 &
launch=$!
pids=("$launch" "$xvfb")
while [ ! -s "$work/status" ]; do
  kill -0 "$launch" 2>/dev/null || { tail -20 "$work/launch.log" >&2; echo "screenshot.sh: the launch ended early" >&2; exit 3; }
  sleep 1
done
# Software rendering needs some seconds for the last messages.
sleep "${MLIC_SCREENSHOT_DELAY:-10}"
mkdir -p "$(dirname "$picture")"
import -window root "$picture"
status=$(head -n 1 "$work/status")
kill -INT "$launch"; wait "$launch" 2>/dev/null || true
echo "screenshot.sh: $picture (calibrate ended with $status)"
exit "$status"
