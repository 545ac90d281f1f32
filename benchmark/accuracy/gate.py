#!/usr/bin/python3
"""The benchmark's gate for every change: scenario `gate`, four seeds, limits on verdict and errors in sigmas.

usage: gate.py BUILD_DIRECTORY
"""

import pathlib

import programs
import row

HERE = pathlib.Path(__file__).resolve().parent
# Four seeds have 4 x 7 components. No trusted error may lie beyond five sigmas. The mean square of 28 normal errors is
# below 2.0 but for one draw in a thousand (chi-square, 28 degrees of freedom: 56.9), and above 0.37 (10.4).
MOST_SIGMAS = 5.0
MEAN_SQUARE = (0.37, 2.0)


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
    lines = programs.gate(HERE / 'run.py', [['--scenarios', 'gate', '--seeds', '11,12,13,14']], faults_of)
    print(f'gate.py: {len(lines)} drives trusted and within their sigmas')


if __name__ == '__main__':
    main()
