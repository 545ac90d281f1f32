#!/usr/bin/env bash
# Builds the benchmarks and prints their tables.
#   run_benchmarks.sh [ARGUMENT OF calibration_benchmark ...]
set -euo pipefail
. "$(dirname "$0")/../scripts/environment.sh"

"$repository/scripts/install_dependencies.sh"
build_mlic -DMLIC_WITH_BENCHMARKS=ON
for name in spline reprojection; do
  "$build/benchmark/${name}_benchmark" --benchmark_out="$build/benchmark/$name.json" --benchmark_out_format=json \
    --benchmark_repetitions=5 --benchmark_report_aggregates_only=true >/dev/null
done
/usr/bin/python3 - "$build/benchmark" <<'EOF'
import json
import sys


def medians(name):
    with open(f'{sys.argv[1]}/{name}.json') as file:
        runs = json.load(file)['benchmarks']
    return {run['run_name']: run['cpu_time'] for run in runs if run.get('aggregate_name') == 'median'}


median = medians('spline')
print('Spline residual with all Jacobians, one core, median of 5 runs')
print(f'{"":34} {"closed form":>12} {"autodiff":>12} {"ratio":>7}')
for text, name in [('IMU: gyroscope and accelerometer', 'Imu'), ('point to plane, time offset included', 'PointToPlane')]:
    closed, autodiff = median[name + 'ClosedForm'], median[name + 'CeresAutodiff']
    print(f'{text:36} {closed:7.0f} ns {autodiff:9.0f} ns {autodiff / closed:7.1f}')
print(f'Preparation of a control point, once for each change: {median["PreparationOfOneControlPoint"]:.0f} ns')

median = medians('reprojection')
print('\nReprojection with all Jacobians, rolling shutter included; camera models alone; one core, median of 5 runs')
print(f'{"":20} {"residual":>12} {"project":>12} {"unproject":>12}')
for number, name in enumerate(['plumb_bob', 'rational_polynomial', 'equidistant', 'double_sphere']):
    times = [median[f'{what}/model:{number}'] for what in ['ReprojectionClosedForm', 'ProjectWithJacobians', 'UnprojectPixel']]
    print(f'{name:20}' + ''.join(f'{time:10.0f} ns' for time in times))
print(f'plumb_bob by autodiff: {median["ReprojectionCeresAutodiff"]:.0f} ns')
EOF
cd "$repository"
echo
echo 'Search for matches among SIFT descriptors, own and by OpenCV'
"$build/benchmark/feature_matcher_benchmark"
echo
echo 'Own small fits and what Ceres takes for them'
"$build/benchmark/small_fit_benchmark"
if [ -x "$build/benchmark/two_view_benchmark" ]; then
  echo
  echo 'Own two-view geometry and PnP beside OpenGV'
  "$build/benchmark/two_view_benchmark"
fi
echo
echo 'Joint solver beside Ceres, hand-held and car, 60 s'
"$build/benchmark/joint_solver_benchmark" 60 "$build/benchmark/joint_solver.csv"
echo
echo 'LiDAR odometry, one thread'
"$build/benchmark/odometry_benchmark"
echo
echo 'Intensity map of the paper'"'"'s rig, made and drawn'
"$build/benchmark/renderer_benchmark"
echo
echo 'Calibration after each stage: worst sensor or pair; of the car without the height over the IMU'
"$build/benchmark/calibration_benchmark" "$@"
