#!/usr/bin/python3
"""Says what differs beyond chance between two runs of the accuracy benchmark, paired by scenario, seed and duration.

usage: compare.py A.csv B.csv

For every error: the median ratio B/A, in how many pairs B is smaller, and p of Wilcoxon's signed-rank test on the
logarithms, adjusted (Holm) for the number of errors looked at. Times and memory are shown and not judged: they depend
on what else the machine did. Exit status: 0 B is nowhere worse, 1 an error is larger beyond chance (p < 0.05), a drive
lost its verdict or a sensor, 2 the files cannot be compared.
"""

import csv
import math
import statistics
import sys

import paired
import row

JUDGED = row.ERRORS + ['intrinsics_px']
SHOWN = ['cpu_s', 'memory_mb']
SIGNIFICANT = 0.05
BETTER_FIRST = ['trusted', 'partial', 'refused', 'none']


def load(path):
    """Rows by scenario, seed and duration."""
    try:
        with open(path, newline='') as file:
            rows = {(line['scenario'], line['seed'], line['duration']): line for line in csv.DictReader(file)}
    except (OSError, KeyError) as error:
        print(f'compare.py: {path}: {error}: a file of run.py is expected', file=sys.stderr)
        sys.exit(2)
    return rows


def ratios(a, b, keys, column):
    """log(B/A) of the pairs that have the column in both."""
    found = []
    for key in keys:
        first, second = a[key].get(column), b[key].get(column)
        if first and second and float(first) > 0 and float(second) > 0:
            found.append(math.log(float(second) / float(first)))
    return found


def table(a, b, keys):
    """Lines to print, and the errors that are worse beyond chance."""
    logs = {column: ratios(a, b, keys, column) for column in JUDGED + SHOWN}
    judged = [column for column in JUDGED if logs[column]]
    adjusted = dict(zip(judged, paired.holm([paired.signed_rank(logs[column]) for column in judged])))
    lines, worse = [f'{"":28} {"pairs":>5} {"median B/A":>10} {"smaller":>8} {"p":>7}'], []
    for column in judged + [column for column in SHOWN if logs[column]]:
        values = logs[column]
        ratio = math.exp(statistics.median(values))
        p = adjusted.get(column)
        word = 'not judged' if p is None else 'the same' if not any(values) else 'no difference beyond chance'
        if p is not None and p < SIGNIFICANT:
            larger = sum(values) > 0
            word = 'worse' if larger else 'better'
            worse += [column] if larger else []
        smaller = sum(value < 0 for value in values)
        shown = '' if p is None else f'{p:.3f}'
        lines.append(f'{column:28} {len(values):5} {ratio:10.3f} {smaller:8} {shown:>7}  {word}')
    return lines, worse


def lost(a, b, keys):
    """Drives whose verdict, or number of calibrated sensors, is worse in b."""
    found = []
    for key in keys:
        rank = [BETTER_FIRST.index(rows[key]['verdict']) for rows in (a, b)]
        if rank[1] > rank[0] or int(b[key]['lost']) > int(a[key]['lost']):
            found.append(f'{key[0]} seed {key[1]}: {a[key]["verdict"]}, {a[key]["lost"]} sensors lost; then '
                         f'{b[key]["verdict"]}, {b[key]["lost"]}')
    return found


def main():
    if len(sys.argv) != 3:
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    a, b = load(sys.argv[1]), load(sys.argv[2])
    keys = sorted(set(a) & set(b))
    if not keys:
        print('compare.py: the files have no scenario and seed in common', file=sys.stderr)
        sys.exit(2)
    lines, worse = table(a, b, keys)
    print(f'{len(keys)} drives in both; {len(set(a) ^ set(b))} in one only')
    print('\n'.join(lines))
    drives = lost(a, b, keys)
    for text in drives:
        print('worse: ' + text)
    print(f'{len(worse)} errors larger beyond chance, {len(drives)} drives with a worse verdict')
    sys.exit(1 if worse or drives else 0)


if __name__ == '__main__':
    main()
