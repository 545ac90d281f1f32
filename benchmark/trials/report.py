#!/usr/bin/python3
"""Tables of trials: who is calibrated, how large errors are, and whether the claimed sigmas hold.

usage: report.py ROWS.csv [ROWS.csv ...]

Normalised errors squared over their number are 1 where sigmas are right; their interval is that of a bootstrap over
drives (components of one drive are not independent). Only what is given counts there: trusted drives, and what partial
ones give. A verdict is right when what is given lies within 5 sigmas, or what is refused beyond.
"""

import collections
import csv
import random
import statistics
import sys

BEYOND = 5.0  # claimed sigmas; a normal error is there once in 1.7 million
RESAMPLES = 2000
PLACES = {'lidar_imu': 'LiDAR to IMU', 'camera_imu': 'camera to IMU', 'lidar_lidar': 'between LiDARs',
          'lidar_camera': 'LiDAR to camera', 'camera_camera': 'between cameras', 'camera': 'camera'}
# What it is called, by what it is multiplied, its unit then.
QUANTITIES = {'rotation': ('rotation', 1.0, ' deg'), 'translation': ('translation', 1e3, ' mm'),
              'offset': ('offset', 1e3, ' ms'), 'drift': ('drift', 1.0, ' ppm'), 'readout': ('readout', 1e3, ' ms'),
              'focal': ('focal length', 1.0, ' px'), 'center': ('centre', 1.0, ' px'),
              'distortion': ('distortion', 1.0, '')}


def load(paths):
    rows = []
    for path in paths:
        with open(path, newline='') as file:
            rows += list(csv.DictReader(file))
    return rows


def drive_of(line):
    return line['kind'], line['split'], line['seed'], line['effect'], line['commit']


def by_drive(rows):
    drives = collections.OrderedDict()
    for line in rows:
        drives.setdefault(drive_of(line), []).append(line)
    return drives


def worst_z(lines):
    return max((float(line['worst_z']) for line in lines if line['worst_z']), default=float('nan'))


def mean_square_interval(groups):
    """Mean of z^2 of (squares, n) by drive, and the 95 percent interval of a bootstrap over drives."""
    def mean(chosen):
        return sum(s for s, _ in chosen) / sum(n for _, n in chosen)
    draw = random.Random(1)
    means = sorted(mean(draw.choices(groups, k=len(groups))) for _ in range(RESAMPLES))
    return mean(groups), means[int(0.025 * RESAMPLES)], means[int(0.975 * RESAMPLES)]


def name_of(parameter):
    """What a kind of parameter is called, by what its errors are multiplied, and their unit then."""
    place, quantity = parameter.rsplit('_', 1)
    name, factor, unit = QUANTITIES[quantity]
    return f'{PLACES[place]}, {name}', factor, unit


def is_given(line):
    return line['verdict'] in ('trusted', 'partial')


def drives_table(drives):
    """By split and world: how many are trusted, and verdicts that were right and wrong."""
    lines = ['| split | world | drives | trusted | partial | refused | none | given beyond 5 sigmas | refused within | '
             'worst z of what is given |', '|---|---|---|---|---|---|---|---|---|---|']
    groups = collections.defaultdict(list)
    for rows in drives.values():
        for world in (rows[0]['world'], 'all'):
            groups[rows[0]['split'], world].append(rows)
    for (split, world), members in sorted(groups.items(), key=lambda item: (item[0][0], item[0][1] == 'all', item[0][1])):
        verdicts = collections.Counter(rows[0]['verdict'] for rows in members)
        given = [worst_z(rows) for rows in members if is_given(rows[0])]
        refused = [worst_z(rows) for rows in members if rows[0]['verdict'] == 'refused']
        # Results without any row have no z.
        worst = max((z for z in given if z == z), default=float('nan'))
        lines.append(f'| {split} | {world} | {len(members)} | {verdicts["trusted"]} | {verdicts["partial"]} | '
                     f'{verdicts["refused"]} | {verdicts["none"]} | {sum(z > BEYOND for z in given)} | '
                     f'{sum(z <= BEYOND for z in refused)} | {worst:.1f} |')
    return lines


def sigmas_table(rows):
    """By split and kind of parameter, of what is given."""
    lines = ['| split | parameter | drives | error, median | worst | by the Cramer-Rao bound, median | '
             'mean z^2 [95 %] | intervals that hold | worst z |', '|---|---|---|---|---|---|---|---|---|']
    groups = collections.defaultdict(list)
    for line in rows:
        if is_given(line) and int(line['n']) > 0:
            groups[line['split'], line['parameter']].append(line)
    for (split, parameter), members in sorted(groups.items()):
        squares = [(float(line['squares']), int(line['n'])) for line in members]
        mean, low, high = mean_square_interval(squares)
        count = sum(n for _, n in squares)
        errors = [float(line['error']) for line in members]
        # Rows of programs that told no bound lack it.
        of_bound = [float(line['error']) / float(line['bound']) for line in members if line.get('bound')]
        inside = sum(int(line['inside']) for line in members)
        bound = f'{statistics.median(of_bound):.2f}' if of_bound else ''
        name, factor, unit = name_of(parameter)
        lines.append(f'| {split} | {name} | {len(members)} | {factor * statistics.median(errors):.3g}{unit} | '
                     f'{factor * max(errors):.3g}{unit} | {bound} | {mean:.2f} [{low:.2f}, {high:.2f}] of {count} | '
                     f'{inside / count:.0%} | {max(float(line["worst_z"]) for line in members):.1f} |')
    return lines


def beyond_table(drives, limit=4.0):
    """Drives with something given that is beyond the limit, worst first: what to look at."""
    found = sorted(((worst_z(rows), key, rows) for key, rows in drives.items()
                    if is_given(rows[0]) and worst_z(rows) > limit), reverse=True)
    lines = ['| split seed | world | motion | rig | IMU | effect | worst z | of |', '|---|---|---|---|---|---|---|---|']
    for z, _, rows in found:
        first = rows[0]
        worst = max((line for line in rows if line['worst_z']), key=lambda line: float(line['worst_z']))
        lines.append(f'| {first["split"]} {first["seed"]} | {first["world"]} | {first["motion"]} | {first["rig"]} | '
                     f'{first["imu"]} | {first["effect"]} | {z:.1f} | {worst["parameter"]} |')
    return lines if found else [f'Nothing given is beyond {limit:g} sigmas.']


def report(rows):
    drives = by_drive(rows)
    return '\n'.join(drives_table(drives) + [''] + sigmas_table(rows) + [''] + beyond_table(drives))


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith('-'):
        sys.exit(__doc__)
    rows = load(sys.argv[1:])
    if not rows:
        sys.exit(f'report.py: no rows in {", ".join(sys.argv[1:])}')
    print(f'commit {", ".join(sorted({line["commit"] for line in rows}))}, effect '
          f'{", ".join(sorted({line["effect"] for line in rows}))}\n')
    print(report(rows))


if __name__ == '__main__':
    main()
