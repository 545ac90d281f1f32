"""What a trial is drawn from: rigs, worlds, motions, IMU grades and single effects. Everything follows from the seed.

World families are split in two: constants of the code may be chosen on drives of the *open* ones; the *closed* ones are
only reported.
"""

import copy
import math
import random

import lenses
from score import rows_of, times

OPEN = ['yard', 'hall', 'car_park', 'slope']
CLOSED = ['street', 'corridor', 'grove']
BY_HAND_ONLY = ['hall', 'corridor']
ON_HILLS = ['slope', 'grove']
KINDS = ['lidar', 'camera', 'camera_imu']

# rate, densities (rad/s/sqrt(Hz), m/s^2/sqrt(Hz)), their walks, sigmas of the biases (rad/s, m/s^2); of data sheets.
IMU_GRADES = {
    'tactical': (200, 5e-5, 5e-4, 5e-7, 5e-6, 5e-4, 0.01),
    'industrial': (400, 1.5e-4, 1.2e-3, 2e-6, 2e-5, 3e-3, 0.03),
    'consumer': (200, 4e-4, 3e-3, 1e-5, 1e-4, 8e-3, 0.1),
}

LIDARS = {
    'spinning_16': {'layout': 'velodyne', 'pattern': {'kind': 'spinning', 'rings': 16, 'vertical_fov_deg': [-15, 15],
                                                      'azimuth_steps': 1200}},
    'spinning_32': {'layout': 'hesai', 'pattern': {'kind': 'spinning', 'rings': 32, 'vertical_fov_deg': [-25, 15],
                                                   'azimuth_steps': 1024}},
    'spinning_64': {'layout': 'ouster', 'pattern': {'kind': 'spinning', 'rings': 64, 'vertical_fov_deg': [-22, 22],
                                                    'azimuth_steps': 512, 'simultaneous_rings': True}},
    'raster': {'layout': 'robosense', 'pattern': {'kind': 'raster', 'fov_deg': [120, 25], 'columns': 300, 'rows': 80}},
    'rosette': {'layout': 'livox', 'pattern': {'kind': 'rosette', 'cone_fov_deg': 70, 'points_per_scan': 20000}},
}


def rings_of(pattern):
    return {'spinning': pattern.get('rings'), 'raster': pattern.get('rows')}.get(pattern['kind'], 1)


def rotation(axis, angle):
    """Row by row; angle in rad."""
    length = math.sqrt(sum(a * a for a in axis))
    x, y, z = (a / length for a in axis)
    c, s = math.cos(angle), math.sin(angle)
    return [c + x * x * (1 - c), x * y * (1 - c) - z * s, x * z * (1 - c) + y * s,
            y * x * (1 - c) + z * s, c + y * y * (1 - c), y * z * (1 - c) - x * s,
            z * x * (1 - c) - y * s, z * y * (1 - c) + x * s, c + z * z * (1 - c)]


def draw_imu(draw, grade, by_hand):
    rate, gyroscope, accelerometer, gyroscope_walk, accelerometer_walk, *biases = IMU_GRADES[grade]
    return {
        'rate': rate,
        'T_body_imu': {'xyz': [0, 0, 1.6] if by_hand else [draw.uniform(-0.5, 0.5), draw.uniform(-0.3, 0.3),
                                                           draw.uniform(0.6, 1.5)],
                       'rpy_deg': [draw.gauss(0, 3), draw.gauss(0, 3), draw.uniform(-180, 180)]},
        'noise': {'gyroscope': gyroscope, 'accelerometer': accelerometer, 'gyroscope_walk': gyroscope_walk,
                  'accelerometer_walk': accelerometer_walk},
        'gyroscope_bias': [draw.gauss(0, biases[0]) for _ in range(3)],
        'accelerometer_bias': [draw.gauss(0, biases[1]) for _ in range(3)],
    }


def draw_lidar(draw, kind, by_hand):
    lidar = copy.deepcopy(LIDARS[kind])
    reach, tilt = (0.2, 15.0) if by_hand else (0.9, 4.0)
    lidar['T_imu_sensor'] = {'xyz': [draw.uniform(-reach, reach), draw.uniform(-reach, reach),
                                     draw.uniform(-0.2, 0.3)],
                             'rpy_deg': [draw.gauss(0, tilt), draw.gauss(0, tilt), draw.uniform(-180, 180)]}
    lidar['time_offset'] = draw.uniform(-0.06, 0.06)
    lidar['phase'] = draw.uniform(0.0, 0.1)
    lidar['range_noise'] = draw.uniform(0.01, 0.03)
    if lidar['layout'] in ('velodyne', 'hesai', 'robosense') and draw.random() < 0.3:
        lidar['stamp'] = 'end'
    return lidar


def draw_camera(draw, by_hand):
    model, size, parameters = lenses.LENSES[draw.choice(sorted(lenses.LENSES))]
    focal = draw.uniform(0.97, 1.03)
    parameters = [focal * p for p in parameters[:2]] + [p + draw.gauss(0, 5) for p in parameters[2:4]] + parameters[4:]
    rolling = draw.random() < 0.5
    reach = 0.15 if by_hand else 0.6
    # z of the camera looks along a horizontal direction, about.
    camera = {'T_imu_sensor': {'xyz': [draw.uniform(-reach, reach) for _ in range(3)],
                               'rpy_deg': [-90 + draw.gauss(0, 8), draw.gauss(0, 8), draw.uniform(-180, 180)]},
              'time_offset': draw.uniform(-0.05, 0.05), 'phase': draw.uniform(0.0, 0.1), 'rate': 10, 'model': model,
              'image_size': list(size), 'intrinsics': parameters,
              'fov_deg': round(lenses.field_of_view_deg((model, size, parameters))),
              'exposure': draw.uniform(0.001, 0.008), 'encoding': draw.choice(['mono8', 'mono_jpeg'])}
    if rolling:
        camera.update(shutter='rolling', readout=draw.uniform(0.005, 0.03))
    return camera


def turned(degrees):
    def apply(draw, trial):
        trial['sensors']['imu']['accelerometer_matrix'] = rotation([draw.gauss(0, 1) for _ in range(3)],
                                                                   math.radians(degrees))
    return apply


def on_lidars(**keys):
    def apply(draw, trial):
        for lidar in trial['sensors'].get('lidars', {}).values():
            lidar.update(keys)
    return apply


def on_cameras(**keys):
    def apply(draw, trial):
        for camera in trial['sensors'].get('cameras', {}).values():
            camera.update(keys)
    return apply


def on_imu(**keys):
    def apply(draw, trial):
        trial['sensors']['imu'].update(keys)
    return apply


def ring_bias(draw, trial):
    for lidar in trial['sensors'].get('lidars', {}).values():
        lidar['ring_bias'] = [draw.gauss(0, 0.01) for _ in range(rings_of(lidar['pattern']))]


def scaled_imu(draw, trial):
    for name in ('gyroscope_matrix', 'accelerometer_matrix'):
        trial['sensors']['imu'][name] = [(1.0 if k % 4 == 0 else 0.0) + draw.gauss(0, 0.003) for k in range(9)]


def combined(draw, trial):
    """All of it at once, each by as much as sensors that are sold show it, or not at all; lenses that nobody sells."""
    trial.update(moving=draw.choice([0, 3, 6, 9]))
    imu = trial['sensors']['imu']
    turn = rows_of(rotation([draw.gauss(0, 1) for _ in range(3)], math.radians(draw.uniform(0, 3))))
    for name, turned_by in (('gyroscope_matrix', None), ('accelerometer_matrix', turn)):
        matrix = [(1.0 if k % 4 == 0 else 0.0) + draw.gauss(0, 0.001) for k in range(9)]
        imu[name] = sum(times(turned_by, rows_of(matrix)), []) if turned_by else matrix
    cut_off = draw.uniform(0.1, 0.25)
    imu.update(low_pass={'gyroscope': cut_off, 'accelerometer': draw.choice([cut_off, draw.uniform(0.1, 0.25)])},
               gravity=draw.uniform(9.78, 9.83),
               stamps={'jitter': draw.uniform(0, 0.0005), 'doubled': draw.choice([0.0, 0.1])})
    if draw.random() < 0.5:
        imu['vibration'] = [{'frequency': draw.uniform(30, 90), 'specific_force': draw.uniform(0, 2),
                             'angular_velocity': draw.uniform(0, 0.02)}]
    if draw.random() < 0.5:
        imu['warm_up'] = {'gyroscope': [draw.gauss(0, 0.002) for _ in range(3)],
                          'accelerometer': [draw.gauss(0, 0.02) for _ in range(3)],
                          'time_constant': draw.uniform(20, 90)}
    for lidar in trial['sensors'].get('lidars', {}).values():
        bias = draw.choice([0.0, 0.003, 0.01])
        lidar.update(ring_bias=[draw.gauss(0, bias) for _ in range(rings_of(lidar['pattern']))],
                     range_walk=draw.uniform(0, 0.02), packet_loss=draw.choice([0.0, 0.03]),
                     rain=draw.choice([0.0, 0.001]), clock_drift_ppm=draw.gauss(0, 20))
    for camera in trial['sensors'].get('cameras', {}).values():
        lens = lenses.draw_lens(draw)
        camera.update(model=lens[0], image_size=list(lens[1]), intrinsics=lens[2],
                      fov_deg=round(lenses.field_of_view_deg(lens)), vignetting=draw.uniform(0.1, 0.6),
                      exposure_drift=draw.uniform(0, 0.4), jpeg_quality=draw.choice([70, 90]),
                      full_well=draw.choice([3000, 10000]), clock_drift_ppm=draw.gauss(0, 20))
        if draw.random() < 0.5:
            camera.update(shortest_exposure=0.0005, exposure=draw.uniform(0.005, 0.02))


# What one effect changes of an otherwise plain drive.
EFFECTS = {
    'none': lambda draw, trial: None,
    'moving': lambda draw, trial: trial.update(moving=6),
    'ring_bias': ring_bias,                       # 1 cm
    'range_walk': on_lidars(range_walk=0.02),     # m for each tenfold weaker echo
    'packet_loss': on_lidars(packet_loss=0.05),
    'rain': on_lidars(rain=0.003),                # 6 % of beams of 20 m
    'accelerometer_turned_1': turned(1.0),
    'accelerometer_turned_3': turned(3.0),
    'imu_scale': scaled_imu,                      # 0.3 % of scale and shear
    'imu_filtered': on_imu(low_pass={'gyroscope': 0.1, 'accelerometer': 0.1}),  # cut-off as a share of the rate
    'imu_lag': on_imu(low_pass={'gyroscope': 0.2, 'accelerometer': 0.1}),  # the accelerometer 5.6 ms later
    'vibration': on_imu(vibration=[{'frequency': 73, 'specific_force': 3, 'angular_velocity': 0.02}]),
    # What a consumer IMU's biases change by within a minute after it is switched on.
    'warm_up': on_imu(warm_up={'gyroscope': [0.005, -0.0035, 0.0025], 'accelerometer': [-0.03, 0.02, 0.024],
                               'time_constant': 30}),
    'gravity': on_imu(gravity=9.79),
    'clock_drift': on_lidars(clock_drift_ppm=50),
    'imu_stamps': on_imu(stamps={'jitter': 0.0005, 'doubled': 0.3}),
    'auto_exposure': on_cameras(exposure=0.015, shortest_exposure=0.0005),
    'combined': combined,
}


def draw_motion(draw, world):
    by_hand = world in BY_HAND_ONLY or draw.random() < 0.6
    if by_hand:
        return True, 'handheld_tilted' if draw.random() < 0.2 else 'handheld'
    return False, 'planar' if world not in ON_HILLS and draw.random() < 0.15 else 'figure_eight'


def draw_trial(kind, seed, split, effect='none'):
    """A trial as a dictionary: sensors (of a sensors file), and what `simulate` is told besides."""
    draw = random.Random(f'{kind}/{split}/{seed}')  # effects leave the drive as it is, so that they pair
    world = (OPEN if split == 'open' else CLOSED)[seed % (4 if split == 'open' else 3)]
    by_hand, motion = draw_motion(draw, world)
    grade = draw.choice(sorted(IMU_GRADES))
    sensors = {'imu': draw_imu(draw, grade, by_hand)}
    types = []
    if kind != 'camera_imu':
        count = draw.choices([1, 2, 3], [6, 3, 1])[0] if kind == 'lidar' else 1
        types = [draw.choice(sorted(LIDARS)) for _ in range(count)]
        sensors['lidars'] = {f'lidar_{i}': draw_lidar(draw, name, by_hand) for i, name in enumerate(types)}
    if kind != 'lidar':
        count = draw.choice([1, 2])
        sensors['cameras'] = {f'camera_{i}': draw_camera(draw, by_hand) for i in range(count)}
    # Cars see neither all of the rotation nor the height well: they come with a guess.
    guess = not by_hand or draw.random() < 0.5
    trial = {'kind': kind, 'seed': seed, 'split': split, 'effect': effect, 'world': world,
             'world_seed': draw.randrange(1 << 30), 'motion': motion, 'guess': guess, 'imu': grade,
             'duration': round(draw.uniform(15, 20) if by_hand else draw.uniform(22, 25), 1), 'moving': 0,
             'sensors': sensors}
    EFFECTS[effect](random.Random(f'{kind}/{split}/{seed}/{effect}'), trial)
    trial['rig'] = '+'.join(types + [c['model'] for c in sensors.get('cameras', {}).values()])  # lenses of effects
    return trial
