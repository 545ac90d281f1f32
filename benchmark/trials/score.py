"""Scores of one calibration against its truth, from the two files (calibration.yaml's format): a row for each kind of
parameter.

Errors are taken along the axes that the file's sigmas belong to (docs/outputs.md): translations and rotations along the
axes of the IMU, of pairs along those of the first sensor. Directions that the result marks as not observable stand at the
guess: they are left out, as are intrinsics that were held, and the distortion where a coefficient of it was held at
another value than the true one.
"""

import math
import pathlib
import sys

import yaml

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / 'accuracy'))

import row

# Of a trial, then of one kind of parameter in it. error: worst of the drive (of a pose: length of the error vector) in
# deg, m, s, ppm or px (focal length); sigma: the claimed one of the same; bound: its Cramer-Rao bound, if the file has it;
# n: components; squares: sum of (error/sigma)^2; inside: how many lie within their 95 percent interval.
TRIAL = ['kind', 'split', 'seed', 'effect', 'world', 'world_seed', 'rig', 'imu', 'motion', 'duration', 'guess', 'commit',
         'verdict', 'exit', 'lost', 'cpu_s']
SCORE = ['parameter', 'n', 'error', 'sigma', 'squares', 'inside', 'worst_z', 'bound']
COLUMNS = TRIAL + SCORE
INTERVAL = 1.959964  # of a normal distribution, 95 percent


def product(a, b):
    """Of two quaternions, x y z w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return [aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz]


def rotation_vector(estimate, truth):
    """Of estimate * truth^-1, deg."""
    x, y, z, w = product(estimate, [-truth[0], -truth[1], -truth[2], truth[3]])
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return [0.0] * 3
    angle = 2.0 * math.atan2(length, abs(w)) * (1.0 if w >= 0.0 else -1.0)
    return [math.degrees(angle) * part / length for part in (x, y, z)]


def pose_errors(found, pose, truth, offsets):
    """Errors, sigmas and bounds (None: not known) of a pose by quantity, all three directions."""
    sigma, bound = found['sigma'], found.get('bound', {})
    return {
        'rotation': (rotation_vector(pose['rotation'], truth['rotation']), sigma['rotation_deg'],
                     bound.get('rotation_deg')),
        'translation': ([a - b for a, b in zip(pose['translation'], truth['translation'])], sigma['translation'],
                        bound.get('translation')),
        'offset': ([offsets[0] - offsets[1]], [sigma['time_offset']],
                   [bound['time_offset']] if 'time_offset' in bound else None),
    }


def observable(sensor, quantity):
    flags = sensor.get('observable', {}).get({'offset': 'time_offset'}.get(quantity, quantity), True)
    return flags if isinstance(flags, list) else [flags] * (1 if quantity == 'offset' else 3)


def pair_observable(name, pair, sensors, quantity):
    """Whether a pair has the quantity observable in all directions, as far as the result says: its axes are not those
    of its sensors."""
    if 'unobservable' in pair:  # tied to each other, not to the IMU
        return all(direction['quantity'] != quantity for direction in pair['unobservable'])
    return all(all(observable(sensors[part], quantity)) for part in name.split('/'))


def twist(matrix, axes):
    """The part of a rotation (row by row) that is about the axes, as a quaternion x y z w (swing-twist)."""
    m = [matrix[0:3], matrix[3:6], matrix[6:9]]
    w = 0.5 * math.sqrt(max(0.0, 1.0 + m[0][0] + m[1][1] + m[2][2]))
    vector = [(m[2][1] - m[1][2]) / (4 * w), (m[0][2] - m[2][0]) / (4 * w), (m[1][0] - m[0][1]) / (4 * w)]
    along = [sum(axis[i] * sum(a * v for a, v in zip(axis, vector)) for axis in axes) for i in range(3)]
    length = math.hypot(w, *along)
    return [part / length for part in along + [w]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def scaled(vector, by):
    return [by * part for part in vector]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def rows_of(matrix):
    return [list(matrix[3 * i:3 * i + 3]) for i in range(3)]


def transposed(rows):
    return [list(column) for column in zip(*rows)]


def times(a, b):
    return [[dot(row, column) for column in transposed(b)] for row in a]


def orthonormal(first, second):
    """Unit vectors along `first` and along what `second` has beside it."""
    first = scaled(first, 1.0 / math.sqrt(dot(first, first)))
    along = dot(first, second)
    rest = [b - along * a for a, b in zip(first, second)]
    return first, scaled(rest, 1.0 / math.sqrt(dot(rest, rest)))


def gyroscope_axes(matrix):
    """The rotation Q of M_w = L Q with a lower triangle L, as rows (docs/method.md, section 1)."""
    first, second = orthonormal(matrix[0], matrix[1])
    return [first, second, cross(first, second)]


def accelerometer_axes(matrix):
    """The rotation R of M_a = R L with a lower triangle L, as rows."""
    columns = transposed(matrix)
    third, second = orthonormal(columns[2], columns[1])
    return transposed([cross(second, third), second, third])


def in_axes_of(imu, true):
    """Turns the poses of a truth into the axes that a result's IMU has (docs/outputs.md): about the directions
    `of_accelerometer` these are the accelerometer's, else the gyroscope's."""
    if 'axes' not in imu or 'gyroscope_matrix' not in true['imu']:
        return
    axes = imu.get('alignment', {}).get('of_accelerometer', [])
    to_gyroscope = gyroscope_axes(rows_of(true['imu']['gyroscope_matrix']))
    found = accelerometer_axes(rows_of(imu['accelerometer_matrix']))
    of_truth = accelerometer_axes(times(rows_of(true['imu']['accelerometer_matrix']), transposed(to_gyroscope)))
    # What the result does not have of the accelerometer's rotation.
    missing = twist(sum(times(transposed(found), of_truth), []), axes)
    turn = product(missing, twist(sum(to_gyroscope, []), [[1, 0, 0], [0, 1, 0], [0, 0, 1]]))
    back = [-turn[0], -turn[1], -turn[2], turn[3]]
    for sensor in true['sensors'].values():
        pose = sensor['T_imu_sensor']
        pose['rotation'] = product(turn, pose['rotation'])
        pose['translation'] = product(product(turn, pose['translation'] + [0.0]), back)[:3]


class Collected:
    """Errors, sigmas and bounds of all components, by kind of parameter."""

    def __init__(self):
        self.parts = {}

    def add(self, parameter, errors, sigmas, flags, bounds=None):
        kept = [(e, s, b) for e, s, b, flag in zip(errors, sigmas, bounds or [math.nan] * len(errors), flags)
                if flag and s > 0.0]
        if kept:
            self.parts.setdefault(parameter, []).append(kept)

    def rows(self):
        for parameter, groups in self.parts.items():
            worst = max(groups, key=lambda group: math.hypot(*(e for e, _, _ in group)))
            errors, sigmas, bounds = (math.hypot(*values) for values in zip(*worst))
            z = [abs(e) / s for group in groups for e, s, _ in group]
            yield {'parameter': parameter, 'n': len(z), 'error': f'{errors:.4g}', 'sigma': f'{sigmas:.4g}',
                   'squares': f'{sum(v * v for v in z):.4f}', 'inside': sum(v < INTERVAL for v in z),
                   'worst_z': f'{max(z):.3f}', 'bound': '' if math.isnan(bounds) else f'{bounds:.4g}'}


def add_intrinsics(collected, found, truth):
    if 'intrinsics_sigma' not in found or found['intrinsics']['model'] != truth['intrinsics']['model']:
        return
    pairs = zip(found['intrinsics']['params'], truth['intrinsics']['params'], found['intrinsics_sigma'])
    errors = [(a - b, s) for a, b, s in pairs]
    held = [s == 0.0 and a != b for a, b, s in zip(found['intrinsics']['params'], truth['intrinsics']['params'],
                                                   found['intrinsics_sigma'])]
    for name, part in [('focal', errors[:2]), ('center', errors[2:4]), ('distortion', errors[4:])]:
        # Coefficients that stand beside ones held elsewhere than the truth has them make up for these.
        if name == 'distortion' and any(held[4:]):
            continue
        # Held parameters have no sigma.
        collected.add(f'camera_{name}', [e for e, _ in part], [s for _, s in part], [True] * len(part))
    readouts = [sensor.get('rolling_shutter_readout') for sensor in (found, truth)]
    if None not in readouts and 'readout_sigma' in found:
        collected.add('camera_readout', [readouts[0] - readouts[1]], [found['readout_sigma']], [True])


def refer_clocks(found, true):
    """True offsets of clocks that drift, where the estimated ones hold."""
    for name, sensor in found.items():
        truth_of = true.get(name, {})
        if 'clock_drift_ppm' in sensor and 'clock_drift_ppm' in truth_of:
            apart = 1e-9 * (sensor['clock_reference_ns'] - truth_of['clock_reference_ns'])
            truth_of['time_offset'] += 1e-6 * truth_of['clock_drift_ppm'] * apart


def score(calibration, truth):
    """Rows of SCORE, verdict and number of lost sensors. calibration, truth: paths; the first may not exist."""
    true = yaml.safe_load(pathlib.Path(truth).read_text())
    if not pathlib.Path(calibration).exists():
        return [], 'none', len(true['sensors'])
    found = yaml.safe_load(pathlib.Path(calibration).read_text())
    in_axes_of(found.get('imu', {}), true)
    refer_clocks(found['sensors'], true['sensors'])
    collected = Collected()
    sensors = {name: sensor for name, sensor in found['sensors'].items()
               if name in true['sensors'] and sensor.get('verdict') != 'rejected'}
    types = {name: sensor['type'] for name, sensor in true['sensors'].items()}
    for name, sensor in sensors.items():
        truth_of = true['sensors'][name]
        offsets = (sensor['time_offset'], truth_of['time_offset'])
        for quantity, (errors, sigmas, bounds) in pose_errors(sensor, sensor['T_imu_sensor'], truth_of['T_imu_sensor'],
                                                              offsets).items():
            collected.add(f'{row.kind_of(name, types)}_{quantity}', errors, sigmas, observable(sensor, quantity),
                          bounds)
        if 'clock_drift_ppm' in sensor:
            collected.add(f'{row.kind_of(name, types)}_drift',
                          [sensor['clock_drift_ppm'] - truth_of.get('clock_drift_ppm', 0.0)],
                          [sensor['clock_drift_sigma_ppm']], [True])
        add_intrinsics(collected, sensor, truth_of)
    for name, pair in found.get('pairs', {}).items():
        tied = 'unobservable' in pair or all(part in sensors for part in name.split('/'))
        if name not in true['pairs'] or 'sigma' not in pair or not tied:
            continue
        parts = [[both['sensors'][part] for part in name.split('/')] for both in (found, true)]
        # Sensors that are not tied to the IMU have no offsets.
        timed = all('time_offset' in sensor for sensor in parts[0])
        offsets = [second['time_offset'] - first['time_offset'] for first, second in parts] if timed else [math.nan] * 2
        for quantity, (errors, sigmas, bounds) in pose_errors(pair, pair['T_a_b'], true['pairs'][name]['T_a_b'],
                                                              offsets).items():
            shown = pair_observable(name, pair, sensors, quantity) and (timed or quantity != 'offset')
            collected.add(f'{row.kind_of(name, types)}_{quantity}', errors, sigmas, [shown] * len(errors), bounds)
    return list(collected.rows()), found['verdict'], len(types) - len(sensors)
