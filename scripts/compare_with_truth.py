#!/usr/bin/python3
"""Prints the errors of a calibration.yaml against the truth of a simulated drive (same format).

usage: compare_with_truth.py CALIBRATION TRUTH

One line for each sensor against the IMU and for each pair of sensors: geodesic angle, translation error along the
axes of the first frame, time offset, and the largest error in units of its reported sigma. Errors along directions
that the file marks as unobservable are listed too: they are those of the guess.
"""

import itertools
import math
import sys

import yaml


def multiply(a, b):
    """Hamilton product, x y z w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def conjugate(q):
    return (-q[0], -q[1], -q[2], q[3])


def rotate(q, v):
    return multiply(multiply(q, (*v, 0.0)), conjugate(q))[:3]


def rotation_vector(q):
    """Of the quaternion, in degrees; precise for tiny angles as well."""
    sine = math.sqrt(sum(c * c for c in q[:3]))
    angle = 2.0 * math.atan2(sine, abs(q[3]))
    scale = math.copysign(math.degrees(angle) / sine if sine > 0.0 else math.degrees(2.0), q[3])
    return tuple(scale * c for c in q[:3])


def pose(entry):
    transform = entry.get('T_imu_sensor', entry.get('T_a_b'))
    rotation = transform['rotation']
    norm = math.sqrt(sum(c * c for c in rotation))
    return tuple(c / norm for c in rotation), tuple(transform['translation'])


def relative(a, b):
    """T_a_b from T_imu_a and T_imu_b."""
    inverse = conjugate(a[0])
    return multiply(inverse, b[0]), rotate(inverse, [y - x for x, y in zip(a[1], b[1])])


def pose_error(estimate, truth):
    """Left rotation error in degrees and translation error in metres, both along the first frame's axes."""
    return (rotation_vector(multiply(estimate[0], conjugate(truth[0]))),
            tuple(x - y for x, y in zip(estimate[1], truth[1])))


def errors(calibration, truth):
    """Rows (name, rotation deg (3), translation m (3), time offset s, sigma or None), sensors first, then pairs."""
    rows = []
    sensors = calibration.get('sensors') or {}
    for name, entry in sensors.items():
        reference = truth['sensors'][name]
        rotation, translation = pose_error(pose(entry), pose(reference))
        rows.append((name, rotation, translation, entry['time_offset'] - reference['time_offset'],
                     entry.get('sigma')))
    pairs = calibration.get('pairs') or {}
    keys = list(pairs) or ['/'.join(pair) for pair in itertools.combinations(sensors, 2)]
    for key in keys:
        a, b = key.split('/')
        reference = relative(pose(truth['sensors'][a]), pose(truth['sensors'][b]))
        if key in pairs:
            estimate, sigma = pose(pairs[key]), pairs[key].get('sigma')
        else:
            estimate, sigma = relative(pose(sensors[a]), pose(sensors[b])), None
        rotation, translation = pose_error(estimate, reference)
        offset = math.nan
        if a in sensors and b in sensors:
            offset = (sensors[b]['time_offset'] - sensors[a]['time_offset'] -
                      truth['sensors'][b]['time_offset'] + truth['sensors'][a]['time_offset'])
        rows.append((key, rotation, translation, offset, sigma))
    return rows


def in_sigmas(rotation, translation, offset, sigma):
    if not sigma:
        return math.nan
    terms = list(zip(rotation, sigma.get('rotation_deg', []))) + list(zip(translation, sigma.get('translation', [])))
    if not math.isnan(offset) and sigma.get('time_offset'):
        terms.append((offset, sigma['time_offset']))
    return max((abs(e) / s for e, s in terms if s > 0.0), default=math.nan)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with open(sys.argv[1], encoding='utf-8') as file:
        calibration = yaml.safe_load(file)
    with open(sys.argv[2], encoding='utf-8') as file:
        truth = yaml.safe_load(file)
    rows = errors(calibration, truth)
    width = max([len(row[0]) for row in rows] + [10])
    print(f'verdict: {calibration["verdict"]}')
    print(f'{"":{width}}  {"rotation":>9}  {"x":>8} {"y":>8} {"z":>8}  {"offset":>9}  {"worst in":>8}')
    print(f'{"":{width}}  {"deg":>9}  {"mm":>8} {"mm":>8} {"mm":>8}  {"ms":>9}  {"sigmas":>8}')
    for name, rotation, translation, offset, sigma in rows:
        angle = math.sqrt(sum(c * c for c in rotation))
        x, y, z = (1000.0 * c for c in translation)
        worst = in_sigmas(rotation, translation, offset, sigma)
        print(f'{name:{width}}  {angle:9.4f}  {x:8.2f} {y:8.2f} {z:8.2f}  {1000.0 * offset:9.4f}  {worst:8.1f}')
    for name, entry in (calibration.get('sensors') or {}).items():
        for direction in entry.get('unobservable') or []:
            print(f'{name}: {direction["quantity"]} along {direction["direction"]} was held at the guess'
                  f' (sigma {direction["sigma"]})')


if __name__ == '__main__':
    main()
