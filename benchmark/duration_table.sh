#!/usr/bin/env bash
# How time, memory and errors of a calibration go with the length of the drive: the paper rig's 4 LiDARs, figure-eight.
#   duration_table.sh [SECONDS ...]        (default: 15 30 60 120; the longest is simulated, all are calibrated)
# Prints a table in Markdown. CPU seconds tell more than wall seconds where other programs run.
set -euo pipefail
. "$(dirname "$0")/../scripts/environment.sh"

durations=("$@")
if [ ${#durations[@]} -eq 0 ]; then durations=(15 30 60 120); fi
longest=$(printf '%s\n' "${durations[@]}" | sort -g | tail -n 1)
programs=${MLIC_PROGRAMS:-$build/devel/lib/mlic} # programs that are built already, if given
if [ -z "${MLIC_PROGRAMS:-}" ]; then
  "$repository/scripts/install_dependencies.sh" >&2
  build_mlic >&2
fi
directory=$(mktemp -d "${TMPDIR:-/tmp}/mlic_durations.XXXXXX")
trap 'rm -rf "$directory"' EXIT
drive=$directory/drive
cd "$repository"
"$programs/simulate" --sensors config/simulation/paper_rig_lidars.yaml --scenario figure_eight --duration "$longest" \
  --seed 1 --output "$drive.bag" >&2

echo '| drive | wall | CPU | peak memory | LiDAR-IMU | in x and y | offset | LiDAR-LiDAR |'
echo '|---|---|---|---|---|---|---|---|'
for seconds in "${durations[@]}"; do
  /usr/bin/python3 - "$programs/calibrate" "$drive" "$seconds" <<'PYTHON'
import itertools
import resource
import subprocess
import sys
import time

import numpy as np
import yaml


def matrix(sensor):
    """T_imu_sensor, 4 x 4."""
    x, y, z, w = sensor['T_imu_sensor']['rotation']
    T = np.eye(4)
    T[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                 [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                 [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    T[:3, 3] = sensor['T_imu_sensor']['translation']
    return T


def degrees(a, b):
    """Angle between the rotations of two transforms; by the sine, which is exact near zero."""
    return np.degrees(2.0 * np.arcsin(np.linalg.norm(a[:3, :3] - b[:3, :3]) / np.sqrt(8.0)))


program, drive, seconds = sys.argv[1:]
output = f'{drive}_{seconds}'
start = time.monotonic()
status = subprocess.run([program, '--rig', drive + '_rig.yaml', '--bag', drive + '.bag', '--output', output,
                         '--duration', seconds, '--fresh'], stdout=subprocess.DEVNULL).returncode
wall = time.monotonic() - start
if status != 0:
    sys.exit(f'calibrate ended with status {status} on {seconds} s')
used = resource.getrusage(resource.RUSAGE_CHILDREN)
with open(output + '/calibration.yaml') as file:
    found = yaml.safe_load(file)['sensors']
with open(drive + '_truth.yaml') as file:
    truth = yaml.safe_load(file)['sensors']
a = {name: matrix(sensor) for name, sensor in found.items()}
b = {name: matrix(truth[name]) for name in found}
pairs = [(np.linalg.inv(a[i]) @ a[k], np.linalg.inv(b[i]) @ b[k]) for i, k in itertools.combinations(a, 2)]
print(f'| {seconds} s | {wall:.0f} s | {used.ru_utime + used.ru_stime:.0f} s | {used.ru_maxrss / 1048576:.2f} GB | '
      f'{max(degrees(a[n], b[n]) for n in a):.4f} deg | '
      f'{max(1e3 * np.linalg.norm(a[n][:2, 3] - b[n][:2, 3]) for n in a):.2f} mm | '
      f'{max(1e3 * abs(found[n]["time_offset"] - truth[n]["time_offset"]) for n in a):.3f} ms | '
      f'{max(degrees(p, q) for p, q in pairs):.4f} deg, '
      f'{max(1e3 * np.linalg.norm(p[:3, 3] - q[:3, 3]) for p, q in pairs):.2f} mm |', flush=True)
PYTHON
done
