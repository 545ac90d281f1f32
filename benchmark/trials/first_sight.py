#!/usr/bin/python3
"""Writes the tables of trials at first sight into docs/benchmark.md, between its markers.

usage: first_sight.py [FILE.md]

Of results/first_sight: each drive once, as the build found it that first saw it (docs/benchmark.md names exceptions).
"""

import pathlib
import sys

import report

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / 'accuracy'))

from page import PAGE, replace_section

ROWS = HERE / 'results/first_sight'
BEGIN, END = '<!-- trials: written by benchmark/trials/first_sight.py -->', '<!-- end of trials -->'
RIGS = {'lidar': 'LiDARs and IMU', 'camera': 'One LiDAR, cameras and IMU', 'camera_imu': 'Cameras and IMU'}


def runs_of_seeds(rows):
    """'360-365, 370' of the seeds of these rows."""
    seeds = sorted({int(line['seed']) for line in rows})
    runs = []
    for seed in seeds:
        if runs and seed == runs[-1][1] + 1:
            runs[-1][1] = seed
        else:
            runs.append([seed, seed])
    return ', '.join(f'{first}-{last}' if last > first else f'{first}' for first, last in runs)


def section(rows):
    """The tables of each kind of rig, in the order of RIGS."""
    lines = []
    for kind, rig in RIGS.items():
        of_kind = [line for line in rows if line['kind'] == kind]
        if not of_kind:
            continue
        drives = report.by_drive(of_kind)
        again = len(drives) - len({key[:3] for key in drives})
        if again:
            sys.exit(f'first_sight.py: {again} drives of {kind} are there more than once, expected once; take the rows of '
                     'later builds out')
        seeds = '; '.join(f'{split} {runs_of_seeds([line for line in of_kind if line["split"] == split])}'
                          for split in sorted({line['split'] for line in of_kind}))
        lines += ([''] if lines else []) + [f'**{rig}** (seeds {seeds}):', ''] + report.drives_table(drives)
        lines += [''] + report.sigmas_table(of_kind) + ['', 'Given beyond 4 sigmas:', ''] + report.beyond_table(drives)
    return lines


def main():
    if len(sys.argv) > 2 or sys.argv[1:2] == ['-h']:
        sys.exit(__doc__)
    rows = report.load(sorted(ROWS.glob('*.csv')))
    page = pathlib.Path(sys.argv[1]) if len(sys.argv) == 2 else PAGE
    replace_section(page, BEGIN, END, section(rows))
    print(f'first_sight.py: {len(report.by_drive(rows))} drives in {page}')


if __name__ == '__main__':
    main()
