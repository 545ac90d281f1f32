#!/usr/bin/python3
"""Says what differs beyond chance between two runs of the trials, paired by drive.

usage: compare.py A.csv B.csv [--across-effects]

As benchmark/accuracy/compare.py: for each kind of parameter the median ratio B/A of the errors and p of Wilcoxon's
signed-rank test, adjusted (Holm); then drives whose verdict is worse, and trusted results that are beyond 5 sigmas in B
only. --across-effects pairs drives that differ in the effect. Exit status: 0 B is nowhere worse, 1 it is, 2 the files
cannot be compared.
"""

import math
import pathlib
import statistics
import sys

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / 'accuracy'))

import paired
import report

SIGNIFICANT = 0.05
BETTER_FIRST = ['trusted', 'partial', 'refused', 'none']


def load(path, across_effects):
    """Rows of each drive."""
    drives = {}
    for line in report.load([path]):
        key = (line['kind'], line['split'], int(line['seed'])) + (() if across_effects else (line['effect'],))
        drives.setdefault(key, []).append(line)
    return drives


def ratios(a, b, keys):
    """log(B/A) of the errors, by kind of parameter, of drives that have it in both."""
    found = {}
    for key in keys:
        of_a, of_b = ({line['parameter']: float(line['error']) for line in drives[key] if line['error']}
                      for drives in (a, b))
        for parameter in sorted(set(of_a) & set(of_b)):
            if of_a[parameter] > 0 and of_b[parameter] > 0:
                found.setdefault(parameter, []).append(math.log(of_b[parameter] / of_a[parameter]))
    return found


def table(logs):
    """Lines to print, and the kinds of parameter that are worse beyond chance."""
    names = sorted(logs)
    adjusted = paired.holm([paired.signed_rank(logs[name]) for name in names])
    lines, worse = [f'{"":28} {"pairs":>5} {"median B/A":>10} {"smaller":>8} {"p":>7}'], []
    for name, p in zip(names, adjusted):
        word = 'no difference beyond chance'
        if p < SIGNIFICANT:
            word = 'worse' if sum(logs[name]) > 0 else 'better'
            worse += [name] if word == 'worse' else []
        lines.append(f'{name:28} {len(logs[name]):5} {math.exp(statistics.median(logs[name])):10.3f} '
                     f'{sum(value < 0 for value in logs[name]):8} {p:7.3f}  {word}')
    return lines, worse


def worse_drives(a, b, keys):
    found = []
    for key in keys:
        name = ' '.join(str(part) for part in key)
        rank = [BETTER_FIRST.index(drives[key][0]['verdict']) for drives in (a, b)]
        if rank[1] > rank[0]:
            found.append(f'{name}: {a[key][0]["verdict"]}, then {b[key][0]["verdict"]}')
        z = [report.worst_z(drives[key]) for drives in (a, b)]
        if b[key][0]['verdict'] == 'trusted' and z[1] > report.BEYOND and not z[0] > report.BEYOND:
            found.append(f'{name}: trusted at {z[1]:.1f} sigmas, before {z[0]:.1f}')
    return found


def main():
    files = [argument for argument in sys.argv[1:] if not argument.startswith('--')]
    if len(files) != 2 or set(sys.argv[1:]) - set(files) - {'--across-effects'}:
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    a, b = (load(path, '--across-effects' in sys.argv) for path in files)
    keys = sorted(set(a) & set(b))
    if not keys:
        print('compare.py: the files have no drive in common', file=sys.stderr)
        sys.exit(2)
    lines, worse = table(ratios(a, b, keys))
    print(f'{len(keys)} drives in both; {len(set(a) ^ set(b))} in one only')
    print('\n'.join(lines))
    drives = worse_drives(a, b, keys)
    for text in drives:
        print('worse: ' + text)
    sys.exit(1 if worse or drives else 0)


if __name__ == '__main__':
    main()
