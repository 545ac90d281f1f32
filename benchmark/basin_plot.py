#!/usr/bin/python3
"""Share of starts from which map matching finds the camera, from tables of basin_benchmark.

basin_plot.py FIGURE.png TABLE.csv [TABLE.csv ...]: writes the figure and prints a table (Markdown)."""

import csv
import sys

import matplotlib

matplotlib.use('Agg')
import matplotlib.pyplot as plt

FOUND_WITHIN_DEG = 0.1


def median(values):
    values = sorted(values)
    return 0.5 * (values[(len(values) - 1) // 2] + values[len(values) // 2])


def main(figure, tables):
    _, axes = plt.subplots(figsize=(6, 3.6))
    print('| camera | start | trials | found (within 0.1 deg) | median error | largest error of those found |')
    print('|---|---|---|---|---|---|')
    for table in tables:
        with open(table) as file:
            rows = list(csv.DictReader(file))
        for shift in sorted({float(row['start_m']) for row in rows}):
            angles, shares = [], []
            for angle in sorted({float(row['start_deg']) for row in rows}):
                trials = [row for row in rows
                          if float(row['start_deg']) == angle and float(row['start_m']) == shift]
                found = [row for row in trials
                         if row['found'] == '1' and float(row['rotation_deg']) < FOUND_WITHIN_DEG]
                angles.append(angle)
                shares.append(100.0 * len(found) / len(trials))
                rotations = [float(row['rotation_deg']) for row in found]
                shifts = [1e3 * float(row['translation_m']) for row in found]
                errors = '| - | - |' if not found else (
                    f'| {median(rotations):.4f} deg, {median(shifts):.2f} mm '
                    f'| {max(rotations):.4f} deg, {max(shifts):.2f} mm |')
                print(f'| {rows[0]["camera"]} | {angle:g} deg, {100 * shift:g} cm | {len(trials)} '
                      f'| {shares[-1]:.0f} % {errors}')
            axes.plot(angles, shares, marker='o', label=f'{rows[0]["camera"]}, {100 * shift:g} cm')
    axes.axhline(95.0, color='gray', linewidth=0.8, linestyle='--')
    axes.set(xlabel='rotation of the start, deg', ylabel='found within 0.1 deg, %', ylim=(0, 104))
    axes.legend(loc='lower left')
    plt.tight_layout()
    plt.savefig(figure, dpi=110)


if __name__ == '__main__':
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(sys.argv[1], sys.argv[2:])
