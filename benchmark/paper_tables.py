#!/usr/bin/python3
"""The paper's tables from what paper_tables.sh has measured.

usage: paper_tables.py --tables OUT              prints them in Markdown
       paper_tables.py --group NAME RIG OUTPUT   the rig file with the LiDARs of one group only, without cameras

The paper's numbers are those of arXiv 2501.02821. Its real vehicle has no known truth: its RMSE is about the mean of its
calibrations, ours about the truth.
"""

import collections
import csv
import math
import pathlib
import statistics
import sys

import yaml

GROUPS = {'front_back': ('front_lidar', 'back_lidar'), 'left_right': ('left_lidar', 'right_lidar')}
NAMES = {'L_A': 'back_lidar', 'L_B': 'front_lidar', 'L_C': 'left_lidar', 'L_D': 'right_lidar', 'C_A': 'cam_back_120',
         'C_D': 'cam_front_120', 'C_E': 'cam_left_190', 'C_F': 'cam_right_190'}

# Table 1: spread in cm (x, y, z; none of z to the IMU) and deg (roll, pitch, yaw), RMSE in cm and deg.
Accuracy = collections.namedtuple('Accuracy', 'kind name spread turn rmse_cm rmse_deg')
ACCURACY = [
    Accuracy('lidar-imu', 'front_lidar', (1.44, 2.01), (0.1, 0.19, 0.11), 0.921, 0.079),
    Accuracy('lidar-imu', 'back_lidar', (1.26, 1.45), (0.1, 0.20, 0.12), 0.657, 0.083),
    Accuracy('lidar-imu', 'left_lidar', (1.07, 1.25), (0.14, 0.12, 0.17), 0.884, 0.079),
    Accuracy('lidar-imu', 'right_lidar', (1.64, 2.62), (0.1, 0.13, 0.17), 1.167, 0.079),
    Accuracy('camera-imu', 'cam_back_120', (1.74, 1.14), (0.12, 0.11, 0.19), 0.745, 0.085),
    Accuracy('camera-imu', 'cam_left_190', (0.93, 1.2), (0.07, 0.12, 0.18), 0.636, 0.084),
    Accuracy('camera-imu', 'cam_right_190', (1.55, 1.52), (0.19, 0.1, 0.08), 0.729, 0.082),
    Accuracy('camera-imu', 'cam_front_120', (0.86, 0.8), (0.12, 0.11, 0.17), 0.431, 0.079),
    Accuracy('lidar-lidar', 'L_C/L_B', (0.33, 2.08, 1.06), (0.04, 0.01, 0.02), 0.769, 0.016),
    Accuracy('lidar-lidar', 'L_D/L_B', (0.16, 1.23, 0.64), (0.06, 0.03, 0.02), 0.508, 0.023),
    Accuracy('lidar-lidar', 'L_C/L_A', (1.2, 1.29, 0.22), (0.07, 0.02, 0.03), 0.563, 0.025),
    Accuracy('lidar-lidar', 'L_D/L_A', (1.23, 1.3, 0.23), (0.03, 0.01, 0.02), 0.683, 0.015),
    Accuracy('camera-camera', 'C_D/C_E', (0.19, 0.20, 0.57), (0.01, 0.01, 0.01), 0.210, 0.005),
    Accuracy('camera-camera', 'C_D/C_F', (0.76, 0.19, 0.33), (0.01, 0.02, 0.02), 0.315, 0.007),
    Accuracy('camera-camera', 'C_E/C_F', (1.04, 0.37, 0.43), (0.01, 0.01, 0.01), 0.423, 0.011),
    Accuracy('lidar-camera', 'L_A/C_A', (1.12, 0.39, 0.5), (0.05, 0.02, 0.01), 0.547, 0.022),
    Accuracy('lidar-camera', 'L_B/C_D', (0.59, 0.1, 1.08), (0.02, 0.02, 0.08), 0.492, 0.034),
    Accuracy('lidar-camera', 'L_C/C_E', (1.07, 0.23, 1.8), (0.12, 0.02, 0.01), 0.713, 0.050),
    Accuracy('lidar-camera', 'L_D/C_F', (1.15, 0.05, 1.15), (0.09, 0.02, 0.01), 0.695, 0.030)]
REPROJECTION = {'cam_back_120': 1.6132, 'cam_front_120': 1.8345, 'cam_left_190': 1.6376, 'cam_right_190': 1.7345}  # px
ENTROPY = {'front_lidar': (-5.395, -5.186, -5.125), 'back_lidar': (-5.339, -5.026, -5.054),
           'left_lidar': (-5.454, -5.149, -5.256), 'right_lidar': (-5.468, -5.125, -5.234)}  # ours, +0.5, -0.5 deg
THICKNESS = {'L_B/L_C': (2.285, 4.348), 'L_C/L_A': (2.207, 4.556), 'L_A/L_D': (1.867, 5.424),
             'L_D/L_B': (1.902, 4.254)}  # cm: ours, hand-eye
EPIPOLAR = {'C_D/C_E': (1.361, 3.564), 'C_D/C_F': (1.29, 3.985), 'C_E/C_F': (0.89, 3.647)}  # px


def segments(out):
    """The folders of those that have been calibrated."""
    return sorted(path.parent.parent for path in out.glob('segment_*/calibration/calibration.yaml'))


def rows_of(path):
    """Rows of a CSV file; none where there is no such file."""
    if not path.exists():
        return []
    with open(path, newline='') as file:
        return list(csv.DictReader(file))


def ours(name):
    """Our name of a sensor or pair of the paper."""
    return '/'.join(NAMES.get(part, part) for part in name.split('/'))


def turned_about(pair):
    return '/'.join(reversed(pair.split('/')))


def pair_of(values, name):
    """Of a pair, whichever of its sensors comes first."""
    return values.get(ours(name), values.get(turned_about(ours(name))))


def mean(values):
    values = [value for value in values if value is not None]
    return statistics.fmean(values) if values else None


def number(value, decimals):
    return '' if value is None else f'{value:.{decimals}f}'


def table(title, note, header, lines):
    lines = [line for line in lines if any(line[1:])]
    print(f'**{title}** ({note})\n')
    if not lines:
        print('not measured: the rig has no such sensors\n')
        return
    print('| ' + ' | '.join(header) + ' |\n|' + '---|' * len(header))
    for line in lines:
        print('| ' + ' | '.join(line) + ' |')
    print()


METHODS = {'hand_eye': 'hand-eye', 'pairwise': 'pairwise'}  # rivals of one run, by evaluate's names


def accuracy(out):
    def found(name):
        return {row['name']: row for row in rows_of(out / name / 'repeatability.csv')}
    joint = found('repeatability')
    rivals = {method: found('repeatability_' + method) for method in METHODS}
    lines = []
    for paper in ACCURACY:
        if pair_of(joint, paper.name) is None:
            continue
        axes = 'xyz'[:len(paper.spread)]

        def norm(rows, prefix, suffix='', axes=axes, scale=1.0, name=paper.name):
            row = pair_of(rows, name)
            return None if row is None else scale * math.sqrt(sum(float(row[prefix + axis + suffix]) ** 2 for axis in axes))
        centimetres = [norm(rows, 'rmse_', scale=100) for rows in (joint, *rivals.values())]
        degrees = [norm(rows, 'rmse_rotation_', '_deg', 'xyz') for rows in (joint, *rivals.values())]
        lines.append([paper.kind, paper.name, number(math.hypot(*paper.spread), 2),
                      number(norm(joint, 'spread_', scale=100), 2), number(math.hypot(*paper.turn), 3),
                      number(norm(joint, 'spread_rotation_', '_deg', 'xyz'), 4), number(paper.rmse_cm, 3),
                      *(number(value, 3) for value in centimetres), number(paper.rmse_deg, 3),
                      *(number(value, 4) for value in degrees)])
    names = ['ours', *METHODS.values()]
    table(f'Accuracy over {len(segments(out))} segments', 'the paper\'s table 1; +- in cm and deg, norms over the axes; to the '
          'IMU x and y only, as the paper has no z there; RMSE: the paper\'s about its mean, the others about the truth',
          ['', '', 'paper +- cm', 'ours', 'paper +- deg', 'ours', 'paper RMSE cm', *names, 'paper RMSE deg', *names], lines)


def values_of(out, file, kind, key, value):
    """Of each thing that the segments' file has: the mean over the segments."""
    of = collections.defaultdict(list)
    for segment in segments(out):
        for row in rows_of(segment / 'evaluation' / file):
            if kind is None or all(row[name] == wanted for name, wanted in kind.items()):
                of[key(row)].append(float(row[value]))
    return {name: mean(values) for name, values in of.items()}


def reprojection(out):
    def pixels(state, camera):
        found = values_of(out, 'reprojection_errors.csv', {'calibration': state, 'lidar': 'all'}, lambda row: row['camera'],
                          'median_px')
        return number(found.get(camera), 2)
    lines = [[name, number(paper, 2), *(pixels(state, name) for state in ('calibration', 'truth', *METHODS))]
             for name, paper in REPROJECTION.items()]
    table('Reprojection of the LiDAR map into the camera', 'table 3, px; the paper\'s mean, else medians over matches of the map '
          'of all LiDARs with photos that no solve used', ['', 'paper', 'ours', 'truth', *METHODS.values()],
          [line for line in lines if line[2]])


def groups(out):
    def sensors(path):
        return yaml.safe_load(path.read_text())['sensors'] if path.exists() else {}
    everything = sensors(out / 'segment_1/calibration/calibration.yaml')
    lines = []
    for group, names in GROUPS.items():
        alone = sensors(out / group / 'calibration.yaml')
        for name in names:
            if 'T_imu_sensor' not in alone.get(name, {}) or 'T_imu_sensor' not in everything.get(name, {}):
                continue
            a, b = alone[name]['T_imu_sensor'], everything[name]['T_imu_sensor']
            cosine = abs(sum(p * q for p, q in zip(a['rotation'], b['rotation'])))
            distance = [1e3 * (p - q) for p, q in zip(a['translation'], b['translation'])]
            lines.append([name, group.replace('_', ' with '), number(math.degrees(2 * math.acos(min(1.0, cosine))), 4),
                          number(math.hypot(*distance[:2]), 2), number(abs(distance[2]), 2)])
    table('Groups', 'table 4: LiDARs calibrated in pairs, against all four; the paper\'s differ by up to 0.12 deg and 20 '
          'mm', ['', 'group', 'deg', 'x and y, mm', 'z, mm'], lines)


def entropy(out):
    turned = {degrees: values_of(out, 'turned_entropy.csv', {'degrees': degrees}, lambda row: row['lidar'], 'mean')
              for degrees in ('0.0', '0.1', '0.5')}
    maps = {state: values_of(out, f'map_quality_{state}.csv', {'kind': 'map_entropy'}, lambda row: row['name'], 'value')
            for state in ('truth', *METHODS)}
    lines = [[name, number(paper[0], 3), number(max(paper[1:]) - paper[0], 3), number(turned['0.0'].get(name), 3),
              *(number(of_state.get(name), 3) for of_state in maps.values())] +
             [number(turned[degrees][name] - turned['0.0'][name], 3) for degrees in ('0.1', '0.5')]
             for name, paper in ENTROPY.items() if name in turned['0.0']]
    table('Map entropy of each LiDAR', 'table 5, nats; maps of different places cannot be compared, their rise when the '
          'LiDAR is turned can', ['', 'paper', 'rise at 0.5 deg', 'ours', 'truth', *METHODS.values(), 'rise at 0.1 deg',
                                  'at 0.5 deg'], lines)


def thickness(out):
    found = {state: values_of(out, file, {'kind': 'overlap_thickness'}, lambda row: row['name'], 'value')
             for state, file in (('ours', 'map_quality.csv'), ('truth', 'map_quality_truth.csv'),
                                 *((method, f'map_quality_{method}.csv') for method in METHODS))}

    def centimetres(state, pair):
        value = pair_of(found[state], pair)
        return number(None if value is None else 100 * value, 2)
    lines = [[pair, number(paper[0], 2), number(paper[1], 2), *(centimetres(state, pair) for state in found)]
             for pair, paper in THICKNESS.items()]
    table('Thickness where two LiDARs overlap', 'table 6, cm, of the map; other methods on our trajectory',
          ['', 'paper', 'paper, hand-eye', 'ours', 'truth', *METHODS.values()], [line for line in lines if line[3]])


def epipolar(out):
    def pixels(state, pair):
        found = values_of(out, 'epipolar_errors.csv', {'calibration': state}, lambda row: row['a'] + '/' + row['b'],
                          'median_px')
        return number(pair_of(found, pair), 3)
    lines = [[pair, number(paper[0], 2), number(paper[1], 2),
              *(pixels(state, pair) for state in ('calibration', 'truth', *METHODS))] for pair, paper in EPIPOLAR.items()]
    table('Epipolar errors', 'table 7, px, median of new matches in images that no solve used',
          ['', 'paper', 'paper, hand-eye', 'ours', 'truth', *METHODS.values()],
          [line for line in lines if line[3]])


def write_group(name, rig_file, output):
    rig = yaml.safe_load(pathlib.Path(rig_file).read_text())
    rig['lidars'] = {lidar: rig['lidars'][lidar] for lidar in GROUPS[name]}
    rig.pop('cameras', None)
    pathlib.Path(output).write_text(yaml.safe_dump(rig, sort_keys=False))


def main():
    if len(sys.argv) == 5 and sys.argv[1] == '--group' and sys.argv[2] in GROUPS:
        write_group(*sys.argv[2:])
    elif len(sys.argv) == 3 and sys.argv[1] == '--tables':
        for part in (accuracy, reprojection, groups, entropy, thickness, epipolar):
            part(pathlib.Path(sys.argv[2]))
    else:
        sys.exit(__doc__)


if __name__ == '__main__':
    main()
