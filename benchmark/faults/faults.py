"""What is done to a sound drive: one entry of FAULTS for each row of the table that run.py makes.

A fault changes the messages of the bag, the rig file, or the bag's bytes. Nothing is drawn but from its name.
"""

import collections
import copy
import math
import operator
import random
import struct

import genpy

FRONT, BACK, IMU, LEFT, RIGHT = '/front/points', '/back/points', '/imu/data', '/cam_left/image_raw', '/cam_right/image_raw'
LIDARS, CAMERAS = (FRONT, BACK), (LEFT, RIGHT)

# name; drive (DRIVES of run.py); topics whose messages `change` sees; change(message, seconds, draw): list of
# (message, delay of its record in s); rig(rig as read from YAML): changes it; bytes(path): changes the file;
# hurt: sensors that may be lost; refusable: the whole may be refused or be bad input; shifted: sensors whose true time
# offset the fault changes, so that theirs is not judged; says: a part of the report's lines that must be there, any case.
Fault = collections.namedtuple('Fault', 'name drive topics change rig bytes hurt refusable shifted says',
                               defaults=[(), None, None, None, (), False, (), ''])


def keep(message):
    return [(message, 0.0)]


def losing(share):
    return lambda message, seconds, draw: [] if draw.random() < share else keep(message)


def doubling(share):
    return lambda message, seconds, draw: keep(message) * (2 if draw.random() < share else 1)


def delaying(share, delay):
    return lambda message, seconds, draw: [(message, delay if draw.random() < share else 0.0)]


def within(begin, end, change):
    return lambda message, seconds, draw: change(message, seconds, draw) if begin <= seconds < end else keep(message)


def dropped(message, seconds, draw):
    return []


def edited(edit):
    def change(message, seconds, draw):
        edit(message, seconds, draw)
        return keep(message)
    return change


def jumping(after, step):
    def edit(message, seconds, draw):
        if seconds >= after:
            message.header.stamp += genpy.Duration.from_sec(step)
    return edited(edit)


def drifting(ppm):
    return edited(lambda message, seconds, draw: setattr(
        message.header, 'stamp', message.header.stamp + genpy.Duration.from_sec(1e-6 * ppm * seconds)))


def scaled(vector, factor):
    for axis in 'xyz':
        setattr(vector, axis, factor * getattr(vector, axis))


def spikes(message, seconds, draw):
    if draw.random() < 0.005:
        message.angular_velocity.y += draw.choice((-20.0, 20.0))


def clipped(message, seconds, draw):
    for axis in 'xyz':
        value = getattr(message.angular_velocity, axis)
        setattr(message.angular_velocity, axis, max(-0.8, min(0.8, value)))


def unknown_readings(message, seconds, draw):
    if draw.random() < 0.02:
        message.angular_velocity.x = math.nan


def frozen_axis(message, seconds, draw):
    message.angular_velocity.z = 0.0


class Repeating:
    """A driver that hangs: from `begin` to `end`, its last data with new stamps. For one drive."""

    def __init__(self, begin, end=math.inf):
        self.begin, self.end, self.last = begin, end, None

    def __call__(self, message, seconds, draw):
        if not self.begin <= seconds < self.end or self.last is None:
            self.last = message.data
        else:
            message.data = self.last
        return keep(message)


def with_ranges(change):
    """Changes the points of a cloud by change(index, draw): a factor of the range, nan for no point."""
    def edit(message, seconds, draw):
        data = bytearray(message.data)
        places = [field.offset for name in 'xyz' for field in message.fields if field.name == name]
        for index in range(message.width * message.height):
            factor = change(index, draw)
            if factor == 1.0:
                continue
            for place in places:
                at = index * message.point_step + place
                struct.pack_into('<f', data, at, factor * struct.unpack_from('<f', data, at)[0])
        message.data = bytes(data)
    return edited(edit)


def turned(after, degrees):
    """A LiDAR that comes loose: from `after` s on, it is turned about its x axis."""
    sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))

    def edit(message, seconds, draw):
        if seconds < after:
            return
        data = bytearray(message.data)
        y, z = (field.offset for name in 'yz' for field in message.fields if field.name == name)
        for at in range(0, message.width * message.height * message.point_step, message.point_step):
            b, c = struct.unpack_from('<f', data, at + y)[0], struct.unpack_from('<f', data, at + z)[0]
            struct.pack_into('<f', data, at + y, cosine * b - sine * c)
            struct.pack_into('<f', data, at + z, sine * b + cosine * c)
        message.data = bytes(data)
    return edited(edit)


def brightness(table):
    table = bytes(max(0, min(255, int(round(table(value))))) for value in range(256))
    return edited(lambda message, seconds, draw: setattr(message, 'data', bytes(message.data).translate(table)))


def blurred(width):
    """A mean over `width` pixels of each row: what a turn during the exposure does."""
    def edit(message, seconds, draw):
        data, out = bytes(message.data), bytearray(message.data)
        for row in range(message.height):
            line = data[row * message.step:row * message.step + message.width]
            total = sum(line[:width])
            for column in range(message.width - width):
                out[row * message.step + column + width // 2] = total // width
                total += line[column + width] - line[column]
        message.data = bytes(out)
    return edited(edit)


def halved(value, centre):
    """A focal length, or a coordinate of a centre, in an image of half the size: centres of pixels are integers."""
    return 0.5 * value - 0.25 * centre


# The right camera of the drive, handheld_stereo.yaml in half the size: width, height; fx fy cx cy; k1 k2 p1 p2 k3.
SIZE = (376, 240)
FOCAL = (halved(390.6, 0), halved(391.2, 0), halved(379.7, 1), halved(237.2, 1))
LENS = (-0.0887, 0.0171, -0.0003, 0.0005, -0.0009)


def distorted(a, b):
    k1, k2, p1, p2, k3 = LENS
    s = a * a + b * b
    n = 1 + s * (k1 + s * (k2 + s * k3))
    return n * a + 2 * p1 * a * b + p2 * (s + 2 * a * a), n * b + p1 * (s + 2 * b * b) + 2 * p2 * a * b


def undistorted(x, y):
    a, b = x, y
    for _ in range(8):
        c, d = distorted(a, b)
        a, b = a + x - c, b + y - d
    return a, b


class Loose:
    """A camera that comes loose: from `after` s on, it is turned about its vertical axis. Where it then looks past the
    edge of what it saw before, the edge is repeated."""

    def __init__(self, after, degrees):
        self.after, self.angle, self.corners, self.weights = after, math.radians(degrees), None, None

    def place(self, column, row):
        """The pixel, before it came loose, of what it sees at this pixel now."""
        fx, fy, cx, cy = FOCAL
        a, b = undistorted((column - cx) / fx, (row - cy) / fy)
        sine, cosine = math.sin(self.angle), math.cos(self.angle)
        depth = cosine - sine * a
        a, b = distorted((cosine * a + sine) / depth, b / depth)
        return max(0.0, min(SIZE[0] - 1.001, fx * a + cx)), max(0.0, min(SIZE[1] - 1.001, fy * b + cy))

    def prepare(self):
        first, weights = [], []
        for row in range(SIZE[1]):
            for column in range(SIZE[0]):
                u, v = self.place(column, row)
                first.append(int(v) * SIZE[0] + int(u))
                right, below = round(256 * (u % 1)), round(256 * (v % 1))
                weights.append(((256 - right) * (256 - below), right * (256 - below), (256 - right) * below,
                                right * below))
        self.corners = [operator.itemgetter(*[at + step for at in first]) for step in (0, 1, SIZE[0], SIZE[0] + 1)]
        self.weights = weights

    def __call__(self, message, seconds, draw):
        if seconds >= self.after:
            if not self.corners:
                self.prepare()
            data = bytes(message.data)
            message.data = bytes((p * a + q * b + r * c + s * d + 32768) >> 16 for (a, b, c, d), p, q, r, s in
                                 zip(self.weights, *[corner(data) for corner in self.corners]))
        return keep(message)


def stamped_on_arrival(message, seconds, draw):
    message.header.stamp += genpy.Duration.from_sec(0.01 + draw.expovariate(1 / 0.004))


def called(encoding):
    return edited(lambda message, seconds, draw: setattr(message, 'encoding', encoding))


def in_colour(message, seconds, draw):
    message.encoding, message.step = 'bgr8', 3 * message.width
    data, colours = bytes(message.data), bytearray(3 * len(message.data))
    colours[0::3] = colours[1::3] = colours[2::3] = data
    message.data = bytes(colours)


def exchanging(kind, a, b, frames):
    """frames: the rig file says which frames the messages have."""
    def change(rig):
        first, second = rig[kind][a], rig[kind][b]
        first['topic'], second['topic'] = second['topic'], first['topic']
        if not frames:
            first.pop('frame_id', None), second.pop('frame_id', None)
    return change


def inverse_guess(kind, name):
    return lambda rig: invert(rig[kind][name]['T_imu_sensor'])


def invert(pose):
    roll, pitch, yaw = (math.radians(angle) for angle in pose['rpy_deg'])
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, yaw))
    r = [[cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
         [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
         [-sp, cp * sr, cp * cr]]  # Rz Ry Rx, as URDF
    t = pose['xyz']
    pose['xyz'] = [-sum(r[k][i] * t[k] for k in range(3)) for i in range(3)]
    pose['rpy_deg'] = [math.degrees(angle) for angle in (math.atan2(r[1][2], r[2][2]),
                                                         math.asin(max(-1.0, min(1.0, -r[0][2]))),
                                                         math.atan2(r[0][1], r[0][0]))]


def wrong_view(factor):
    def change(rig):
        rig['cameras']['cam_left']['fov_deg'] *= factor
    return change


def cut_off(path):
    size = path.stat().st_size
    with open(path, 'r+b') as file:
        file.truncate(int(0.8 * size))


def _lidars(name, *values, **named):
    return Fault(name, 'lidars', *values, **named)


def without_guess(rig):
    for sensor in [*rig['lidars'].values(), *rig['cameras'].values()]:
        del sensor['T_imu_sensor'], sensor['sigma']


def _guessed(name, *values, **named):
    return Fault(name, 'cameras', *values, **named)


def _cameras(name, *values, rig=None, **named):
    """Without a guess."""
    def change(content):
        without_guess(content)
        if rig:
            rig(content)
    return _guessed(name, *values, rig=change, **named)


FAULTS = [
    _lidars('none'),
    _lidars('imu_lost_10', (IMU,), losing(0.1)),
    _lidars('imu_doubled_10', (IMU,), doubling(0.1)),
    _lidars('imu_late_10', (IMU,), delaying(0.1, 0.3)),
    _lidars('imu_nan_2', (IMU,), edited(unknown_readings), says='NaN'),
    _lidars('imu_spikes', (IMU,), edited(spikes), says='spikes'),
    _lidars('imu_axis_frozen', (IMU,), edited(frozen_axis), refusable=True, says='gyroscope z'),
    _lidars('imu_axis_frozen_2_s', (IMU,), within(5, 7, edited(frozen_axis)), says='gyroscope z'),
    _lidars('imu_saturated', (IMU,), edited(clipped), refusable=True, says='range'),
    _lidars('imu_in_g', (IMU,), edited(lambda m, s, d: scaled(m.linear_acceleration, 1 / 9.80665)), refusable=True,
            says='looks like g'),
    _lidars('imu_in_deg_s', (IMU,), edited(lambda m, s, d: scaled(m.angular_velocity, 180 / math.pi)), refusable=True,
            says='deg/s'),
    _lidars('imu_gap_1_s', (IMU,), within(6, 7, dropped), says='gap'),
    _lidars('imu_jump_20_ms', (IMU,), jumping(9, 0.02), shifted=('front', 'back'), says='clock jump'),
    _lidars('lidar_lost_10', LIDARS, losing(0.1)),
    _lidars('lidar_doubled_10', LIDARS, doubling(0.1)),
    _lidars('lidar_late_10', LIDARS, delaying(0.1, 0.3)),
    _lidars('lidar_nan_10', (FRONT,), with_ranges(lambda i, d: math.nan if i % 10 == 3 else 1.0)),
    _lidars('lidar_rain_5', (FRONT,), with_ranges(lambda i, d: d.uniform(0.05, 0.9) if i % 20 == 3 else 1.0)),
    _lidars('lidar_dies', (BACK,), within(7, 99, dropped), hurt=('back',)),
    _lidars('lidar_starts_late', (BACK,), within(0, 8, dropped), hurt=('back',)),
    _lidars('lidar_hangs', (BACK,), Repeating(8), hurt=('back',)),
    _lidars('lidar_jump_20_ms', (BACK,), jumping(9, 0.02), hurt=('back',), shifted=('back',), says='clock jump'),
    _lidars('lidar_jump_5_s', (BACK,), jumping(9, 5.0), hurt=('back',), shifted=('back',), says='clock jump'),
    _lidars('lidar_drift_500_ppm', (BACK,), drifting(500), hurt=('back',), shifted=('back',), says='its clock drifts'),
    _lidars('lidar_loose_02_deg', (BACK,), turned(7, 0.2), hurt=('back',), says='of the drive do not agree on it'),
    _lidars('lidar_loose_1_deg', (BACK,), turned(7, 1.0), hurt=('back',), says='back'),
    _lidars('lidar_loose_5_deg', (BACK,), turned(7, 5.0), hurt=('back',), says='back'),
    _lidars('lidars_exchanged', rig=exchanging('lidars', 'front', 'back', frames=False), hurt=('front', 'back'),
            refusable=True, says='topics of front and back look exchanged'),
    _lidars('lidars_exchanged_frames', rig=exchanging('lidars', 'front', 'back', frames=True), hurt=('front', 'back'),
            refusable=True, says='topics of front and back look exchanged'),
    _lidars('guess_inverted', rig=inverse_guess('lidars', 'front'), says='front: '),
    _lidars('bag_cut_off', bytes=cut_off, refusable=True, says='reindex'),
    _cameras('none'),
    _cameras('camera_lost_10', CAMERAS, losing(0.1)),
    _cameras('camera_doubled_10', CAMERAS, doubling(0.1)),
    _cameras('camera_late_10', CAMERAS, delaying(0.1, 0.3)),
    _cameras('camera_stamped_on_arrival', (RIGHT,), edited(stamped_on_arrival), hurt=('cam_right',),
             shifted=('cam_right',)),
    _cameras('camera_dies', (RIGHT,), within(6, 99, dropped), hurt=('cam_right',)),
    _cameras('camera_starts_late', (RIGHT,), within(0, 6, dropped), hurt=('cam_right',)),
    _cameras('camera_hangs', (RIGHT,), Repeating(6), hurt=('cam_right',), says='repeat the one before'),
    _cameras('camera_hangs_5_s', (RIGHT,), Repeating(4, 9), hurt=('cam_right',), says='repeat the one before'),
    _cameras('camera_dark', (RIGHT,), brightness(lambda v: 0.03 * v), hurt=('cam_right',)),
    _cameras('camera_overexposed', (RIGHT,), brightness(lambda v: 8 * v), hurt=('cam_right',)),
    _cameras('camera_blurred', (RIGHT,), blurred(13), hurt=('cam_right',)),
    _cameras('camera_colour', (RIGHT,), edited(in_colour)),
    _cameras('camera_encoding_wrong', (RIGHT,), called('mono16'), hurt=('cam_right',), refusable=True, says=RIGHT),
    _cameras('camera_encoding_unknown', (RIGHT,), called('nv21'), hurt=('cam_right',), refusable=True, says='nv21'),
    _cameras('camera_loose_1_deg', (RIGHT,), Loose(6, 1.0), hurt=('cam_right',), says='of the drive do not agree on it'),
    _cameras('camera_loose_1_deg_late', (RIGHT,), Loose(9, 1.0), hurt=('cam_right',), says='of the drive do not agree on it'),
    _cameras('camera_loose_02_deg', (RIGHT,), Loose(6, 0.2), hurt=('cam_right',), says='of the drive do not agree on it'),
    _cameras('camera_view_30_percent', rig=wrong_view(1.3), hurt=('cam_left',)),
    _cameras('cameras_exchanged_frames', rig=exchanging('cameras', 'cam_left', 'cam_right', frames=True),
             hurt=('cam_left', 'cam_right'), refusable=True, says='topics of cam_left and cam_right look exchanged'),
    _guessed('cameras_guessed'),
    _guessed('cameras_exchanged', rig=exchanging('cameras', 'cam_left', 'cam_right', frames=False),
             hurt=('cam_left', 'cam_right'), refusable=True, says='topics of cam_left and cam_right look exchanged'),
    _guessed('camera_guess_inverted', rig=inverse_guess('cameras', 'cam_left'), says='cam_left: '),
]


def draw_of(fault):
    return random.Random(fault.name)


def faulty(rig, fault):
    rig = copy.deepcopy(rig)
    if fault.rig:
        fault.rig(rig)
    return rig
