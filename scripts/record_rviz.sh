#!/usr/bin/env bash
# Records what RViz shows of a calibration, from start to verdict, and presses the panel's buttons on the way.
#   record_rviz.sh BAG RIG FOLDER      FOLDER, new or empty: gets the frames, NNNN.png after so many seconds
# A first launch is paused, continued and cancelled; a second one goes on from its stages to the end. What each button
# is to do is checked in scripts/press_panel.py. Exit status: 0 where all did it and a verdict was reached.
# Needs a build, what screenshot.sh needs, and xdotool. MLIC_BUILD: build directory.
set -euo pipefail
. "$(dirname "$0")/environment.sh"

[ $# -eq 3 ] || { sed -n '2,6p' "$0" >&2; exit 1; }
bag=$(realpath -- "$1"); rig=$(realpath -- "$2"); folder=$(realpath -m -- "$3")
require_programs Xvfb import rviz xdotool
mkdir -p "$folder"
[ -z "$(ls -A "$folder")" ] || { echo "record_rviz.sh: $folder is not empty" >&2; exit 1; }
source_workspace
start_virtual_display
trap stop_virtual_display EXIT
/usr/bin/python3 "$repository/scripts/press_panel.py" "$bag" "$rig" "$folder"
