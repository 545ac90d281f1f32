"""A row of the accuracy benchmark: what is measured of one calibration, from the files of `calibrate` and `evaluate`.

For each kind of pose (a sensor to the IMU, a pair) and each of rotation (deg), translation (m) and time offset (s): the
worst error, n components, and their errors in claimed sigmas (z), the worst and the root mean square. Directions that
the result marks as not observable stand at the guess: they are left out. Of intrinsics: the worst camera's mean error
over its image, in pixels.
"""

import csv
import math
import pathlib
import re

KINDS = ['lidar_imu', 'camera_imu', 'lidar_lidar', 'lidar_camera', 'camera_camera']
QUANTITIES = {'rotation': 'deg', 'translation': 'm', 'offset': 's'}
ERRORS = [f'{kind}_{quantity}_{unit}' for kind in KINDS for quantity, unit in QUANTITIES.items()]
COLUMNS = (['scenario', 'seed', 'duration', 'commit', 'verdict', 'exit', 'lost'] +
           [f'{kind}_{quantity}_{what}' for kind in KINDS for quantity, unit in QUANTITIES.items()
            for what in (unit, 'z_worst', 'z_rms', 'n')] +
           ['intrinsics_px', 'cpu_s', 'wall_s', 'memory_mb'])


def sensors_of(path):
    """Of a calibration file: type and observable directions of each sensor by name, and the verdict."""
    sensors, name, section, verdict = {}, None, None, None
    for line in pathlib.Path(path).read_text().splitlines():
        if re.match(r'^\w', line):
            section = line.split(':')[0]
            if section == 'verdict':
                verdict = line.split(':', 1)[1].split('#')[0].strip()
        elif section == 'sensors' and re.match(r'^  \w+:\s*$', line):
            name = line.strip()[:-1]
            sensors[name] = {'type': None, 'translation': [True] * 3, 'rotation': [True] * 3, 'offset': [True]}
        elif section == 'sensors' and line.strip() == 'verdict: rejected':
            del sensors[name]
        elif section == 'sensors' and line.startswith('    type:'):
            sensors[name]['type'] = line.split(':')[1].strip()
        elif section == 'sensors' and line.startswith('    observable:'):
            for quantity, key in [('translation', 'translation'), ('rotation', 'rotation'), ('offset', 'time_offset')]:
                flags = re.search(key + r': \[?([a-z, ]+)', line).group(1)
                sensors[name][quantity] = [flag.strip() == 'true' for flag in flags.strip(' ,').split(',')]
    return sensors, verdict


def kind_of(name, types):
    """Which of KINDS the sensor `name`, or the pair 'a/b', is."""
    if '/' not in name:
        return f'{types[name]}_imu'
    return '_'.join(sorted((types[part] for part in name.split('/')), reverse=True))


def components(line, observable):
    """Of a line of errors.csv: for each quantity its errors and those in sigmas, of the observable directions."""
    def some(pattern, flags):
        numbers = [float(line[pattern.format(axis)]) for axis in 'xyz']
        return [number for number, flag in zip(numbers, flags) if flag]
    found = {}
    for quantity, pattern in [('rotation', 'rotation_{}_deg'), ('translation', 'translation_{}')]:
        found[quantity] = (some(pattern, observable[quantity]),
                           some('normalised_' + quantity + '_{}', observable[quantity]))
    flags = observable['offset']
    found['offset'] = ([float(line['time_offset'])][:sum(flags)], [float(line['normalised_time_offset'])][:sum(flags)])
    return found


def summarise(lines, truth_types, sensors):
    """Columns of all kinds from the lines of errors.csv."""
    errors, normalised = {}, {}
    everything = {'translation': [True] * 3, 'rotation': [True] * 3, 'offset': [True]}
    for line in lines:
        kind = kind_of(line['name'], truth_types)
        for quantity, (error, z) in components(line, sensors.get(line['name'], everything)).items():
            error = [value for value in error if math.isfinite(value)]
            if error:
                errors.setdefault((kind, quantity), []).append(math.hypot(*error))
            normalised.setdefault((kind, quantity), []).extend(abs(value) for value in z if math.isfinite(value))
    columns = {}
    for (kind, quantity), values in errors.items():
        columns[f'{kind}_{quantity}_{QUANTITIES[quantity]}'] = f'{max(values):.4g}'
        z = normalised[kind, quantity]
        if z:
            columns[f'{kind}_{quantity}_z_worst'] = f'{max(z):.3f}'
            columns[f'{kind}_{quantity}_z_rms'] = f'{math.sqrt(sum(v * v for v in z) / len(z)):.3f}'
            columns[f'{kind}_{quantity}_n'] = len(z)
    return columns


def read(path):
    with open(path, newline='') as file:
        return list(csv.DictReader(file))


def errors_of(calibration, truth, evaluation):
    """The columns of a row that say how good the result is. Without a result: verdict 'none', all sensors lost."""
    true_sensors, _ = sensors_of(truth)
    if not calibration.exists():
        return {'verdict': 'none', 'lost': len(true_sensors)}
    sensors, verdict = sensors_of(calibration)
    types = {name: sensor['type'] for name, sensor in true_sensors.items()}
    columns = {'verdict': verdict, 'lost': len(set(types) - set(sensors))}
    columns.update(summarise(read(evaluation / 'errors.csv'), types, sensors))
    if (evaluation / 'intrinsics_errors.csv').exists():
        pixels = [float(line['mean_px']) for line in read(evaluation / 'intrinsics_errors.csv')]
        columns['intrinsics_px'] = f'{max(pixels):.4g}'
    return columns
