#!/usr/bin/python3
"""The trials' gate for every change: few drives of open families, limits on verdicts and errors in sigmas.

usage: gate.py BUILD_DIRECTORY
"""

import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / 'accuracy'))

import programs
import report

# Effect and seeds of the open families: plain drives, and what an IMU may have that a simulator's has not.
DRIVES = [('none', '1-4'), ('accelerometer_turned_3', '2,3'), ('gravity', '4'), ('imu_stamps', '1')]
# No trusted error may lie beyond five sigmas. The mean square of some 56 normal errors is below 1.73 but for one draw in
# a thousand (chi-square); errors of one drive are not independent, so twice that.
MEAN_SQUARE = 3.5


def faults_of(rows):
    faults = []
    for (_, split, seed, effect, _), lines in report.by_drive(rows).items():
        name = f'{split} {seed}, {effect}'
        if lines[0]['verdict'] != 'trusted':
            faults.append(f'{name}: {lines[0]["verdict"]}, expected trusted')
        elif report.worst_z(lines) > report.BEYOND:
            faults.append(f'{name}: trusted, {report.worst_z(lines):.1f} claimed sigmas off')
    squares = sum(float(line['squares']) for line in rows if int(line['n']) > 0)
    count = sum(int(line['n']) for line in rows)
    if not faults and squares > MEAN_SQUARE * count:
        faults.append(f'mean square of {count} errors in sigmas is {squares / count:.2f}, expected {MEAN_SQUARE} at most')
    return faults


def main():
    runs = [['--split', 'open', '--seeds', seeds, '--effect', effect] for effect, seeds in DRIVES]
    lines = programs.gate(HERE / 'run.py', runs, faults_of)
    print(f'gate.py: {len(report.by_drive(lines))} drives trusted and within their sigmas')


if __name__ == '__main__':
    main()
