#!/usr/bin/python3
"""The benchmark's gate for every change: scenario `gate`, two seeds, limits on verdict and errors in sigmas.

usage: gate.py BUILD_DIRECTORY
"""

import csv
import pathlib
import subprocess
import sys
import tempfile

import row

HERE = pathlib.Path(__file__).resolve().parent
# Two seeds have 2 x 7 components. No trusted error may lie beyond five sigmas. The mean square of 14 normal errors is
# below 2.6 but for one draw in a thousand (chi-square, 14 degrees of freedom: 36.1), and above 0.2 (2.9).
MOST_SIGMAS = 5.0
MEAN_SQUARE = (0.2, 2.6)


def faults_of(rows):
    faults, squares, count = [], 0.0, 0
    for line in rows:
        name = f'{line["scenario"]} seed {line["seed"]}'
        if line['verdict'] != 'trusted' or line['exit'] != '0' or line['lost'] != '0':
            faults.append(f'{name}: {line["verdict"]}, exit {line["exit"]}, {line["lost"]} sensors lost; not trusted')
            continue
        for quantity in row.QUANTITIES:
            column = f'lidar_imu_{quantity}'
            if float(line[column + '_z_worst']) > MOST_SIGMAS:
                faults.append(f'{name}: {quantity} is {line[column + "_z_worst"]} claimed sigmas off')
            squares += int(line[column + '_n']) * float(line[column + '_z_rms']) ** 2
            count += int(line[column + '_n'])
    if not faults and not MEAN_SQUARE[0] < squares / count < MEAN_SQUARE[1]:
        faults.append(f'mean square of {count} errors in sigmas is {squares / count:.2f}, expected {MEAN_SQUARE}')
    return faults


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory(prefix='mlic_accuracy_gate_') as folder:
        rows = pathlib.Path(folder) / 'rows.csv'
        subprocess.run([sys.executable, HERE / 'run.py', '--build', sys.argv[1], '--scenarios', 'gate',
                        '--seeds', '11,12', '--rows', rows], check=True)
        with open(rows, newline='') as file:
            lines = list(csv.DictReader(file))
    faults = faults_of(lines)
    if faults:
        sys.exit('\n'.join(faults))
    print(f'gate.py: {len(lines)} drives trusted and within their sigmas')


if __name__ == '__main__':
    main()
