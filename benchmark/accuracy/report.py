#!/usr/bin/python3
"""Writes the tables of the accuracy benchmark into docs/benchmark.md, between its markers.

usage: report.py ROWS.csv [FILE.md]
"""

import csv
import pathlib
import statistics
import subprocess
import sys

import row
import scenarios
from page import PAGE, replace_section

BEGIN, END = '<!-- accuracy: written by benchmark/accuracy/report.py -->', '<!-- end of accuracy -->'
NAMES = {'lidar_imu': 'LiDAR-IMU', 'camera_imu': 'camera-IMU', 'lidar_lidar': 'LiDAR-LiDAR',
         'lidar_camera': 'LiDAR-camera', 'camera_camera': 'camera-camera'}
SHOWN = {'rotation': ('deg', 1.0, '{:.4f}'), 'translation': ('mm', 1e3, '{:.2f}'), 'offset': ('ms', 1e3, '{:.3f}')}


def machine():
    """Processor and cores, as the kernel names them."""
    model = 'unknown processor'
    for line in pathlib.Path('/proc/cpuinfo').read_text().splitlines():
        if line.startswith('model name'):
            model = line.split(':', 1)[1].strip()
            break
    cores = subprocess.run(['nproc'], capture_output=True, text=True).stdout.strip()
    return f'{model}, {cores} cores'


def median_and_worst(lines, column, factor, form):
    values = [factor * float(line[column]) for line in lines if line[column]]
    return f'{form.format(statistics.median(values))} / {form.format(max(values))}' if values else ''


def errors_table(by_scenario):
    lines = ['| scenario | of | rotation, deg | translation, mm | offset, ms |', '|---|---|---|---|---|']
    for name, rows in by_scenario.items():
        for kind in row.KINDS:
            cells = [median_and_worst(rows, f'{kind}_{quantity}_{row.QUANTITIES[quantity]}', factor, form)
                     for quantity, (_, factor, form) in SHOWN.items()]
            if any(cells):
                lines.append(f'| {name} | {NAMES[kind]} | ' + ' | '.join(cells) + ' |')
    return lines


def runs_table(by_scenario):
    lines = ['| scenario | sensors, motion, s | constants chosen on seeds | seeds | trusted | sensors lost | '
             'intrinsics, px | CPU, s | peak memory, GB |', '|---|---|---|---|---|---|---|---|---|']
    for name, rows in by_scenario.items():
        scenario = scenarios.BY_NAME[name]
        trusted = sum(line['verdict'] == 'trusted' for line in rows)
        lines.append(f'| {name} | {scenario.sensors}, {scenario.motion}, {scenario.seconds} | {scenario.tuned} | '
                     f'{", ".join(sorted((line["seed"] for line in rows), key=int))} | {trusted} of {len(rows)} | '
                     f'{sum(int(line["lost"]) for line in rows)} | '
                     f'{median_and_worst(rows, "intrinsics_px", 1.0, "{:.2f}")} | '
                     f'{median_and_worst(rows, "cpu_s", 1.0, "{:.0f}")} | '
                     f'{median_and_worst(rows, "memory_mb", 1.0 / 1024, "{:.2f}")} |')
    return lines


def consistency_table(lines_of_csv):
    """Normalised errors squared over their number, by kind, over all drives."""
    lines = ['| of | rotation | translation | offset |', '|---|---|---|---|']
    for kind in row.KINDS:
        cells = []
        for quantity in SHOWN:
            column, squares, count, worst = f'{kind}_{quantity}', 0.0, 0, 0.0
            for line in lines_of_csv:
                if line[column + '_n']:
                    count += int(line[column + '_n'])
                    squares += int(line[column + '_n']) * float(line[column + '_z_rms']) ** 2
                    worst = max(worst, float(line[column + '_z_worst']))
            cells.append(f'{squares / count:.2f} of {count}, worst {worst:.1f}' if count else '')
        if any(cells):
            lines.append(f'| {NAMES[kind]} | ' + ' | '.join(cells) + ' |')
    return lines


def section(rows):
    by_scenario = {}
    for name in scenarios.BY_NAME:
        of_it = [line for line in rows if line['scenario'] == name]
        if of_it:
            by_scenario[name] = of_it
    commits = ', '.join(sorted({line['commit'] for line in rows}))
    return (
        [f'`benchmark/accuracy/run.py`, commit {commits}; {machine()}. Each cell: median / worst over the seeds of '
         'the worst sensor or pair of a drive. Directions that a result marks as not observable are left out.', ''] +
        runs_table(by_scenario) + [''] + errors_table(by_scenario) +
        ['', 'Errors in claimed sigmas: mean square of all components (1 where sigmas are right), how many, the largest.',
         ''] +
        consistency_table(rows))


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    with open(sys.argv[1], newline='') as file:
        rows = list(csv.DictReader(file))
    if not rows:
        sys.exit(f'report.py: no rows in {sys.argv[1]}')
    page = pathlib.Path(sys.argv[2]) if len(sys.argv) == 3 else PAGE
    replace_section(page, BEGIN, END, section(rows))
    print(f'report.py: {len(rows)} rows in {page}')


if __name__ == '__main__':
    main()
