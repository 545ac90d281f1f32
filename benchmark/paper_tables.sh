#!/usr/bin/env bash
# The tables of the paper (arXiv 2501.02821) on its vehicle, simulated: six figure-eights of 20 s, each calibrated by
# itself, beside the paper's numbers, what the true calibration gives, and other methods on the same drives (hand-eye,
# pairwise: docs/method.md, section 13).
#   paper_tables.sh OUT [SENSORS]      default: config/simulation/paper_rig.yaml; paper_rig_lidars.yaml is 20 times faster
# OUT gets the drives (1.3 GB each with cameras), the calibrations, CSV files and tables.md. What is there already is not
# done again. With cameras a drive takes about 25 minutes of two cores to simulate and 10 to calibrate, and the pairwise
# calibration as long as one of two sensors for each sensor.
set -euo pipefail
. "$(dirname "$0")/../scripts/environment.sh"
[ $# -ge 1 ] || { sed -n '5,8p' "$0" >&2; exit 1; }
mkdir -p "$1"
out=$(cd "$1" && pwd)
sensors=${2:-config/simulation/paper_rig.yaml}
programs=${MLIC_PROGRAMS:-$build/devel/lib/mlic} # programs that are built already, if given
if [ -z "${MLIC_PROGRAMS:-}" ]; then
  "$repository/scripts/install_dependencies.sh" >&2
  build_mlic >&2
fi
cd "$repository"

# calibrate BAG RIG OUTPUT; a calibration that is not trusted is a row of the tables as well.
calibrate() {
  [ -f "$3/calibration.yaml" ] && return
  local status=0
  "$programs/calibrate" --bag "$1" --rig "$2" --output "$3" >"$3.log" 2>&1 || status=$?
  case $status in 0 | 2 | 4) ;; *) tail -n 5 "$3.log" >&2; exit "$status" ;; esac
}

for seed in 1 2 3 4 5 6; do
  segment=$out/segment_$seed
  mkdir -p "$segment"
  if [ ! -f "$segment/drive_truth.yaml" ]; then
    echo "paper_tables.sh: segment $seed of 6: simulating" >&2
    "$programs/simulate" --sensors "$sensors" --scenario figure_eight --duration 20 --seed "$seed" \
      --rotation-error-deg 4.81 --translation-error 0.1 --output "$segment/drive.bag" >"$segment/simulate.log" 2>&1
  fi
  echo "paper_tables.sh: segment $seed of 6: calibrating" >&2
  calibrate "$segment/drive.bag" "$segment/drive_rig.yaml" "$segment/calibration"
  if [ ! -f "$segment/evaluation/evaluation.txt" ]; then
    "$programs/evaluate" --bag "$segment/drive.bag" --rig "$segment/drive_rig.yaml" --truth "$segment/drive_truth.yaml" \
      --calibration "$segment/calibration/calibration.yaml" --method hand_eye --method pairwise \
      --output "$segment/evaluation" >/dev/null
  fi
done
# The same rig in all: the truths differ in the biases of the IMU alone.
for seed in 2 3 4 5 6; do
  diff <(grep T_imu_sensor "$out/segment_1/drive_truth.yaml") <(grep T_imu_sensor "$out/segment_$seed/drive_truth.yaml") >&2
done
# Front with back alone, left with right alone.
for group in front_back left_right; do
  /usr/bin/python3 benchmark/paper_tables.py --group "$group" "$out/segment_1/drive_rig.yaml" "$out/$group.yaml"
  calibrate "$out/segment_1/drive.bag" "$out/$group.yaml" "$out/$group"
done
"$programs/evaluate" --calibration "$out"/segment_?/calibration/calibration.yaml \
  --truth "$out/segment_1/drive_truth.yaml" --output "$out/repeatability" >/dev/null
for method in hand_eye pairwise; do
  "$programs/evaluate" --calibration "$out"/segment_?/evaluation/"$method.yaml" \
    --truth "$out/segment_1/drive_truth.yaml" --output "$out/repeatability_$method" >/dev/null
done
/usr/bin/python3 benchmark/paper_tables.py --tables "$out" | tee "$out/tables.md"
