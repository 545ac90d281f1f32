#!/usr/bin/python3
"""Makes ROS bags and a rig file of a real recording that a public repository holds as pictures and text.

usage: make.py --list
       make.py NAME FILES FOLDER

FILES: the checked-out repository (`git clone`, or `git archive COMMIT | tar -x -C FILES`). FOLDER: gets drive_1.bag,
drive_2.bag, ... and drive_rig.yaml. A new bag begins where the IMU pauses for more than half a second. Needs rosbag's
Python and, for videos, ffmpeg. None of the recordings is part of MLIC.
"""

import argparse
import bisect
import collections
import json
import math
import pathlib
import sys

import genpy
import gopro
import rosbag
from sensor_msgs.msg import CompressedImage, Imu

PAUSE_NS = 500_000_000

# source; commit; licence; truth: what the repository says of it; rig: the rig file; read(files): what it holds.
Recording = collections.namedtuple('Recording', 'source commit licence truth rig read')

# Samples (stamp in ns, gyroscope in rad/s, accelerometer in m/s^2); pictures (stamp in ns, path) of each camera.
Data = collections.namedtuple('Data', 'imu cameras')


def rows_of(path):
    for line in path.read_text().splitlines():
        if line.strip() and not line.startswith('#'):
            yield line.replace(',', ' ').split()


def samples_of(path):
    """Rows of stamp in ns, angular rate and specific force, in the order of their stamps."""
    rows = ((int(row[0]), tuple(map(float, row[1:4])), tuple(map(float, row[4:7]))) for row in rows_of(path))
    return sorted(rows, key=lambda sample: sample[0])


def pictures_of(folder):
    """Pictures that have their stamp in ns as their name."""
    paths = [path for path in folder.iterdir() if path.suffix in ('.jpg', '.png')]
    return sorted((int(path.stem), path) for path in paths)


def read_room(files):
    return Data(samples_of(files / 'imu.txt'), {'color': pictures_of(files / 'cam0/images')})


def read_desk(files):
    # The later driver beside the data adds this to the stamps of pictures: half the exposure and the transfer.
    def late(pictures):
        return [(stamp + 4_075_000, path) for stamp, path in pictures]
    return Data(samples_of(files / 'imu/imu.txt'),
                {'left': late(pictures_of(files / 'Left')), 'right': late(pictures_of(files / 'Right'))})


def read_phone(files):
    """The file mixes two devices, one that lies still and sends gravity, and the phone, which repeats its samples."""
    folder = files / 'MH_01_easy/mav0'
    imu, last = [], None
    for sample in samples_of(folder / 'imu0/data.csv'):
        still = math.hypot(*sample[2]) > 7.0
        if not still and sample[1:] != last:
            imu.append(sample)
            last = sample[1:]
    return Data(imu, {'color': pictures_of(folder / 'cam0/data')})


def objects_of(path):
    """JSON objects of a file, one after the other."""
    decoder, text, at = json.JSONDecoder(), path.read_text().strip(), 0
    while at < len(text):
        value, end = decoder.raw_decode(text, at)
        yield value
        at = end + len(text[end:]) - len(text[end:].lstrip())


def at_time(times, values, time):
    """Values between the two of rising times that stand about a time."""
    k = bisect.bisect(times, time)
    share = (time - times[k - 1]) / (times[k] - times[k - 1])
    return tuple(a + share * (b - a) for a, b in zip(values[k - 1], values[k]))


def read_rooms(files):
    """Gyroscope (type 4 of Android) and accelerometer (1) come apart; forces are taken at the gyroscope's stamps."""
    folder = files / 'slam-mvp/data/slam_session_20250923_102213'
    of_type = collections.defaultdict(dict)
    for row in objects_of(folder / 'data/imu_data.jsonl'):
        of_type[row['sensorType']][row['timestamp']] = tuple(row['values'])
    times, forces = zip(*sorted(of_type[1].items()))
    imu = [(stamp, rate, at_time(times, forces, stamp)) for stamp, rate in sorted(of_type[4].items())
           if times[0] <= stamp < times[-1]]
    pictures = [(row['timestamp'], folder / 'images' / row['fileName'])
                for row in objects_of(folder / 'data/camera_frames.jsonl')]
    return Data(imu, {'color': sorted(pictures)})


EUROC_RIG = '''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  left: {topic: /left/image_raw/compressed, frame_id: left, model: plumb_bob, fov_deg: 80, shutter: global}
  right: {topic: /right/image_raw/compressed, frame_id: right, model: plumb_bob, fov_deg: 80, shutter: global}
'''


def euroc(folder, samples):
    """The stereo pictures in a folder, with what of the whole flight's samples is from half a second before to after."""
    cameras = {side: pictures_of(folder / name / 'data') for side, name in (('left', 'cam0'), ('right', 'cam1'))}
    begin, end = cameras['left'][0][0] - PAUSE_NS, cameras['left'][-1][0] + PAUSE_NS
    return Data([sample for sample in samples if begin <= sample[0] <= end], cameras)


def read_drone(files):
    folder = files / 'tests/data/MicroEurocDataset/mav0'
    return euroc(folder, samples_of(folder / 'imu0/data.csv'))


def read_hall(files):
    """The IMU's stamps went through a spreadsheet, which kept 15 digits; they are those of a grid of 5 ms."""
    first, step = 1_403_636_579_758_555_392, 5_000_000
    imu = []
    for row in rows_of(files / 'mav0/imu0/data.csv'):
        if len(row) != 7 or not row[0][0].isdigit():
            continue
        stamp = first + round((float(row[0]) - first) / step) * step
        imu.append((stamp, tuple(map(float, row[1:4])), tuple(map(float, row[4:7]))))
    return euroc(files / 'meam620-2020-proj2_2/proj2_2/dataset/MachineHall01_reduced', imu)


def read_gopro(name):
    def read(files):
        imu, pictures = gopro.read(files / 'samples' / f'{name}.mp4', files / 'pictures' / name)
        return Data(imu, {'color': pictures})
    return read


RECORDINGS = {
    'room': Recording(
        source='github.com/Zoltan3057/DM-VIO-dataset',
        commit='7f0fcff8a45b7bbcb70f509e8c926454a9971a2b',
        licence='none stated',
        truth='''RealSense by hand in a bedroom, 125 s: colour 1280 x 720, rolling shutter, auto exposure with periods of 33 to
60 ms; IMU 200 Hz. camera.txt: 906.260 906.551 642.896 353.142, no distortion, of the maker. camchain.yaml: T_cam_imu
with 1.4 deg and (12.1, -2.3, -2.3) mm, of unknown origin. Nothing is said of the stamps.''',
        rig='''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  color: {topic: /color/image_raw/compressed, frame_id: color, model: plumb_bob, fov_deg: 70, shutter: rolling}
''',
        read=read_room),
    'desk': Recording(
        source='github.com/ke-zhao/camera',
        commit='7cc26892a9acc3621c087fdf67c9d337d7e53f1b',
        licence='none stated',
        truth='''Stereo 640 x 480 at 20 Hz, IMU 200 Hz, on a desk: at rest but for 0.5 s, so it must be refused. No calibration.''',
        rig='''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  left: {topic: /left/image_raw/compressed, frame_id: left, model: plumb_bob, fov_deg: 90, shutter: global}
  right: {topic: /right/image_raw/compressed, frame_id: right, model: plumb_bob, fov_deg: 90, shutter: global}
''',
        read=read_desk),
    'drone': Recording(
        source='github.com/MIT-SPARK/Kimera-VIO',
        commit='ce8c59b7b273ab5ac29db7e5572e1623760e19c7',
        licence='BSD-2-Clause (the repository); the data are of ASL, ETH Zurich (EuRoC, V1_01_easy), for research',
        truth='''First 4.7 s of EuRoC's V1_01_easy: a drone that stands and whose rotors start, so it must be refused. Sensors as
those of `hall`.''',
        rig=EUROC_RIG,
        read=read_drone),
    'hall': Recording(
        source='github.com/iamliguangming/MEAM620 (images) and '
               'github.com/kalebburnham/IMU-Research (IMU), both checked out in one folder',
        commit='247efe345e2a76fad084d2477e4e821902d0e1c4 and 454019146f6d6db1d6d1c04e8f6c2f184bb7e550',
        licence='none stated; the data are of ASL, ETH Zurich (EuRoC, MH_01_easy), for research',
        truth='''EuRoC's MH_01_easy from 5 to 35 s: a drone that is turned by hand for 14 s, set down with a knock, rests and is
shaken at 26 s. Stereo 752 x 480, global shutter, 20 Hz, triggered by the IMU's clock, stamps in the middle of the
exposure; IMU 200 Hz (ADIS16448). sensor.yaml: left 458.654 457.296 367.215 248.375, -0.28340811 0.07395907 0.00019359
0.0000176; right 457.587 456.134 379.999 255.238, -0.28368365 0.07451284 -0.00010473 -0.0000356; T_BS of both. Another
calibration of the same rig: github.com/VladyslavUsenko/basalt, data/euroc_ds_calib.json.''',
        rig=EUROC_RIG,
        read=read_hall),
    'walk': Recording(
        source='github.com/gopro/gpmf-parser, samples/max-heromode.mp4',
        commit='9a7150632892c7356c91145c889016f07b0ed48d',
        licence='MIT or Apache-2.0',
        truth='''GoPro MAX in hero mode, walking, 10.5 s: video 848 x 480 at 29.97 Hz, stabilised by the camera (its telemetry says
by how much each image is turned, up to 19 deg), so it must be refused: the images are not those of a camera that is
fixed to the IMU. IMU 198 Hz, with times of its own.''',
        rig='''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  color: {topic: /color/image_raw/compressed, frame_id: color, model: plumb_bob, fov_deg: 85, shutter: rolling}
''',
        read=read_gopro('max-heromode')),
    'coast': Recording(
        source='github.com/gopro/gpmf-parser, samples/karma.mp4',
        commit='9a7150632892c7356c91145c889016f07b0ed48d',
        licence='MIT or Apache-2.0',
        truth='''GoPro Hero5 on a drone's gimbal, straight along a coast, 12 s: video 854 x 480 at 29.97 Hz, gyroscope 400 Hz,
accelerometer 200 Hz, no times of their own. The gimbal holds it still, half of the image is sea and clouds: no turns, so
it must be refused. No calibration.''',
        rig='''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  color: {topic: /color/image_raw/compressed, frame_id: color, model: plumb_bob, fov_deg: 90, shutter: rolling}
''',
        read=read_gopro('karma')),
    'rooms': Recording(
        source='github.com/Rajat-Roy/edge-slam-rgb-imu',
        commit='9872d22f2e9c592f6f5ac74ace54592d5c46dfb1',
        licence='none in force ("TBD")',
        truth='''Android phone carried through rooms and over stairs, 52 s: rear camera 640 x 480 at 30 Hz, some images blurred;
IMU 200 Hz. Both are stamped on arrival: the IMU a millisecond late at random and 30 ms after a busy moment, images when the
app gets to them. No calibration; Android's axes put the camera's x along the IMU's -y, and its optical axis along -z.''',
        rig='''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  color: {topic: /color/image_raw/compressed, frame_id: color, model: plumb_bob, fov_deg: 67, shutter: rolling}
''',
        read=read_rooms),
    'phone': Recording(
        source='github.com/AbhinandIITM/VI-SLAM',
        commit='2e8671402fe2706c9a38d2f22f30beadbc022060',
        licence='GPL-3.0 (that of ORB-SLAM3, which it is a copy of; none stated for the data)',
        truth='''Phone by hand in a room, 60 s: pictures 1920 x 1080 over DroidCam (with a text that never moves), IMU over
a socket, stamped on arrival, gravity removed by the phone, so it must be refused as input. No calibration: the
sensor.yaml beside it is that of another camera.''',
        rig='''imu: {topic: /imu/data, frame_id: imu_link}
cameras:
  color: {topic: /color/image_raw/compressed, frame_id: color, model: plumb_bob, fov_deg: 65, shutter: rolling}
''',
        read=read_phone),
}


def header(message, stamp, frame):
    message.header.stamp = genpy.Time(*divmod(stamp, 1_000_000_000))
    message.header.frame_id = frame
    return message


def imu_message(sample):
    stamp, rate, force = sample
    message = header(Imu(), stamp, 'imu_link')
    message.angular_velocity.x, message.angular_velocity.y, message.angular_velocity.z = rate
    message.linear_acceleration.x, message.linear_acceleration.y, message.linear_acceleration.z = force
    message.orientation_covariance[0] = -1.0  # no orientation
    return message


def image_message(stamp, path, frame):
    message = header(CompressedImage(), stamp, frame)
    message.format = 'png' if path.suffix == '.png' else 'jpeg'
    message.data = path.read_bytes()
    return message


def pieces_of(imu):
    """First and last stamp of each stretch without a pause."""
    begin = last = imu[0][0]
    for stamp, _, _ in imu[1:]:
        if stamp - last > PAUSE_NS:
            yield begin, last
            begin = stamp
        last = stamp
    yield begin, last


def write_bag(path, data, begin, end):
    messages = [(sample[0], '/imu/data', imu_message, sample) for sample in data.imu if begin <= sample[0] <= end]
    for name, pictures in data.cameras.items():
        topic = f'/{name}/image_raw/compressed'
        messages += [(stamp, topic, image_message, (stamp, picture, name)) for stamp, picture in pictures
                     if begin <= stamp <= end]
    with rosbag.Bag(str(path), 'w') as bag:
        for stamp, topic, make, content in sorted(messages, key=lambda message: message[:2]):
            message = make(content) if make is imu_message else make(*content)
            bag.write(topic, message, message.header.stamp)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--list', action='store_true', help='what there is and where it comes from')
    parser.add_argument('name', nargs='?', choices=sorted(RECORDINGS))
    parser.add_argument('files', nargs='?', type=pathlib.Path, help='the checked-out repository')
    parser.add_argument('folder', nargs='?', type=pathlib.Path, help='where bags and rig file go')
    arguments = parser.parse_args()
    if arguments.list:
        for name, recording in RECORDINGS.items():
            print(f'{name}: {recording.source}, commit {recording.commit}, licence: {recording.licence}\n{recording.truth}\n')
        return
    if arguments.folder is None:
        parser.error('NAME, FILES and FOLDER, or --list')
    recording = RECORDINGS[arguments.name]
    try:
        data = recording.read(arguments.files)
    except FileNotFoundError as missing:
        sys.exit(f'make.py: {missing.filename} is not there; {arguments.files} must be {recording.source} at {recording.commit}')
    arguments.folder.mkdir(parents=True, exist_ok=True)
    for number, (begin, end) in enumerate(pieces_of(data.imu), 1):
        write_bag(arguments.folder / f'drive_{number}.bag', data, begin, end)
    (arguments.folder / 'drive_rig.yaml').write_text(f'# {recording.source}, commit {recording.commit}\n{recording.rig}')


if __name__ == '__main__':
    main()
