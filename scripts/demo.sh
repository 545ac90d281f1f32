#!/usr/bin/env bash
# From nothing to a calibration: installs what is needed, builds, calibrates a recorded or a simulated drive, says
# where the results are.
#   demo.sh                       simulates a walk with a LiDAR, a stereo camera and an IMU, calibrates them without a
#                                 guess and compares with the truth
#   demo.sh --full                the same of a drive of the paper's vehicle (4 LiDARs, 6 cameras, IMU), with a guess
#   demo.sh BAG RIG [OUTPUT]      calibrates a recording, described by the rig file RIG
# Exit status: that of calibrate (0 trusted, 1 bad input, 2 refused, 3 failure inside, 4 partial, 130 interrupted).
# MLIC_DEMO_DURATION (20): seconds of simulated drive; MLIC_BUILD: build directory; MLIC_RVIZ=false: without RViz.
set -euo pipefail
. "$(dirname "$0")/environment.sh"

usage() { sed -n '2,8p' "$0" >&2; exit 1; }
truth=""
rig_name=handheld_stereo scenario=handheld work="a simulated drive and its calibration (2 to 4 minutes)"
how=(--no-guess --image-rate 5)  # images take most of a walk's time; five in a second show as much
if [ "${1:-}" = --full ]; then
  rig_name=paper_rig scenario=figure_eight how=() work="a simulated drive and its calibration"
  shift
  [ $# -eq 0 ] || usage
fi
case $# in
  0) ;;
  2 | 3)
    bag=$(realpath -- "$1"); rig=$(realpath -- "$2")
    for file in "$bag" "$rig"; do
      [ -f "$file" ] || { echo "demo.sh: no file $file" >&2; exit 1; }
    done
    work="the calibration"
    output=$(realpath -m -- "${3:-$(basename "$bag" .bag)_calibration}")
    ;;
  *) usage ;;
esac

# A first build leaves the tests out, which take half of the time and which test.sh asks for, and makes what the drive
# needs before the other programs. Times: measured on a bare Debian 12 with 2 cores and nothing else to do.
tests=() needed=(all)
if [ ! -f "$build/CMakeCache.txt" ]; then
  tests=(-DBUILD_TESTING=OFF) needed=(calibrate_node evaluate simulate)
  echo "== to come: packages from apt (781 MB, 2 to 5 minutes), a build (once, 6 to 10 minutes on 2 cores)," \
    "$work, and where the results lie"
fi
"$repository/scripts/install_dependencies.sh"
require_host_name
configure_mlic -DMLIC_WITH_ROS=ON "${tests[@]}"
compile_mlic "${needed[@]}"
source_workspace

simulate() {
  local sensors=$repository/config/simulation/$rig_name.yaml duration=${MLIC_DEMO_DURATION:-20}
  local folder=$build/demo/${rig_name}_${scenario}_$duration
  bag=$folder/drive.bag; rig=$folder/drive_rig.yaml; truth=$folder/drive_truth.yaml; output=$folder/calibration
  mkdir -p "$folder"
  # The program is part of the name of a drive: a new build simulates anew.
  if [ -f "$folder/.done" ] && [ "$folder/.done" -nt "$build/devel/lib/mlic/simulate" ] &&
    [ "$folder/.done" -nt "$sensors" ]; then
    echo "== the drive of the last call is used again: $bag"
    return
  fi
  rm -rf "$folder/.done" "$output" "$folder/evaluation"
  echo "== simulating $duration s of $scenario, pictures included: $bag"
  rosrun mlic simulate --sensors "$sensors" --scenario "$scenario" --duration "$duration" --seed 1 --output "$bag" \
    ${how[@]+"${how[@]}"}
  touch "$folder/.done"
  echo "== simulated after $SECONDS s in all"
}
if [ $# -eq 0 ]; then simulate; fi

# roslaunch exits with 0 whatever its nodes did, so the calibration writes its status and its last lines to a file.
status_file=$(mktemp)
trap 'rm -f "$status_file"' EXIT
export MLIC_STATUS_FILE=$status_file
echo "== calibrating"
launch_status=0
roslaunch mlic calibrate.launch rig:="$rig" bag:="$bag" output:="$output" rviz:="${MLIC_RVIZ:-true}" || launch_status=$?
status=$(head -n 1 "$status_file")
echo "== calibrated after $SECONDS s in all"
if [ -z "$status" ]; then
  echo "demo.sh: calibrate did not finish (roslaunch exited with $launch_status)" >&2
  if [ "$launch_status" -ne 0 ]; then exit "$launch_status"; fi
  exit 3
fi

if [ -f "$output/calibration.yaml" ] && [[ $status =~ ^[024]$ ]]; then
  echo "== results in $output:"
  ls "$output"
  if [ -n "$truth" ]; then
    echo "== against the simulated truth (evaluate; also in $(dirname "$output")/evaluation)"
    rosrun mlic evaluate --bag "$bag" --calibration "$output/calibration.yaml" --truth "$truth" \
      --output "$(dirname "$output")/evaluation" || echo "demo.sh: evaluate ended with $?" >&2
  fi
fi
tail -n +2 "$status_file"
if [ -f "$output/report.html" ]; then echo "== read on in $output/report.html"; fi
if [ "${needed[0]}" != all ]; then
  echo "== the result stands; what else there is (export, verify, compare, ...) is built now"
  others=$(compile_mlic) || { echo "$others" >&2; echo "demo.sh: the other programs do not build" >&2; }
fi
exit "$status"
