#!/usr/bin/python3
"""Puts faults into sound drives, calibrates them, and writes what became of it: one CSV row for each fault.

usage: run.py [--build DIR] [--only NAME,...] [--rows FILE.csv]

Good: no crash, no hang, no trusted result beyond five sigmas, no loss of a sensor that the fault leaves alone, and the
fault is told where it can be (faults.py, `says`). Faults that the file has already are not run again. Default file:
benchmark/faults/results/COMMIT.csv. Needs rosbag's Python.
"""

import argparse
import csv
import pathlib
import shutil
import sys
import tempfile

import rosbag
import yaml

HERE = pathlib.Path(__file__).resolve().parent
sys.path += [str(HERE.parent / 'accuracy'), str(HERE.parent / 'trials')]

import faults
import score
from programs import REPOSITORY, Usage, append_rows, commit_of, must

COLUMNS = ['drive', 'fault', 'commit', 'good', 'verdict', 'exit', 'lost', 'worst_z', 'parameter', 'told', 'cpu_s', 'line']
BEYOND = 5.0  # sigmas
STEREO = REPOSITORY / 'config/simulation/handheld_stereo.yaml'


def lidars_of(stereo):
    """The stereo rig's IMU with two LiDARs of 16 rings that look to both sides."""
    spinning = dict(stereo['lidars']['lidar'], pattern={'kind': 'spinning', 'rings': 16, 'vertical_fov_deg': [-15, 15],
                                                        'azimuth_steps': 1000})
    front = dict(spinning, topic=faults.FRONT, frame_id='front')
    back = dict(spinning, topic=faults.BACK, frame_id='back', time_offset=-0.02, phase=0.06,
                T_imu_sensor={'xyz': [-0.21, 0.09, 0.04], 'rpy_deg': [12.0, 31.0, -47.0]})
    return {'imu': stereo['imu'], 'lidars': {'front': front, 'back': back}}


def cameras_of(stereo):
    """The stereo rig with images of half the size and half as often: a quarter of the time."""
    for camera in stereo['cameras'].values():
        focal, lens = camera['intrinsics'][:4], camera['intrinsics'][4:]
        camera.update(rate=10, image_size=[side // 2 for side in camera['image_size']],
                      intrinsics=[faults.halved(value, centre) for value, centre in zip(focal, (0, 0, 1, 1))] + lens)
    return stereo


# Sensors, seconds, what the simulator is told of the rig file's guess; of cameras: as measured by hand, far better than
# the default sigmas say.
DRIVES = {'lidars': (lidars_of, 15, []),
          'cameras': (cameras_of, 12, ['--rotation-error-deg', 1, '--translation-error', 0.02])}


def simulate(simulator, name, folder):
    """The sound drive; the folder holds drive.bag, drive_rig.yaml and drive_truth.yaml."""
    sensors_of, seconds, guess_options = DRIVES[name]
    folder.mkdir()
    sensors = sensors_of(yaml.safe_load(STEREO.read_text()))
    (folder / 'sensors.yaml').write_text(yaml.safe_dump(sensors, sort_keys=False))
    command = [simulator, '--sensors', folder / 'sensors.yaml', '--scenario', 'handheld', '--duration', seconds, '--seed',
               5, '--output', folder / 'drive.bag'] + guess_options
    must(Usage(command, folder / 'simulate.log'), 'simulate', folder / 'simulate.log')


def write_bag(source, path, fault):
    draw = faults.draw_of(fault)
    with rosbag.Bag(source) as bag, rosbag.Bag(path, 'w') as copy:
        begin = bag.get_start_time()
        for topic, raw, time in bag.read_messages(raw=True):
            if topic not in fault.topics:
                copy.write(topic, raw, time, raw=True)
                continue
            message = raw[4]()
            message.deserialize(raw[1])
            for changed, delay in fault.change(message, time.to_sec() - begin, draw):
                copy.write(topic, changed, time + faults.genpy.Duration.from_sec(delay))


def prepare(sound, folder, fault):
    """The faulty bag and rig file."""
    bag = folder / 'drive.bag'
    if fault.change:
        write_bag(sound / 'drive.bag', bag, fault)
    else:
        shutil.copy(sound / 'drive.bag', bag)
    if fault.bytes:
        fault.bytes(bag)
    rig = faults.faulty(yaml.safe_load((sound / 'drive_rig.yaml').read_text()), fault)
    (folder / 'rig.yaml').write_text(yaml.safe_dump(rig, sort_keys=False))
    return bag, folder / 'rig.yaml'


def lost_of(calibration, fault):
    """Sensors without a result that the fault should have left alone, and all that have none."""
    if not calibration.exists():
        return [], []
    sensors = yaml.safe_load(calibration.read_text())['sensors']
    lost = [name for name, sensor in sensors.items() if sensor.get('verdict') == 'rejected']
    return [name for name in lost if name not in fault.hurt], lost


def judged(rows, fault):
    """Rows of the score, without the clocks that the fault changes."""
    return [line for line in rows if not (fault.shifted and line['parameter'].endswith(('_offset', '_drift')))]


def measure(calibrator, sound, fault, commit, folder, threads):
    bag, rig = prepare(sound, folder, fault)
    output, log = folder / 'calibration', folder / 'calibrate.log'
    used = Usage([calibrator, '--rig', rig, '--bag', bag, '--output', output, '--threads', threads], log)
    calibration = output / 'calibration.yaml'
    rows, verdict, _ = score.score(calibration, sound / 'drive_truth.yaml')
    worst = max(judged(rows, fault), key=lambda line: float(line['worst_z']), default=None)
    z = float(worst['worst_z']) if worst else 0.0
    innocent, lost = lost_of(calibration, fault)
    text = log.read_text(errors='replace')
    told = fault.says.lower() in text.lower()
    usable = verdict in ('trusted', 'partial')
    expected = (0, 4) if not fault.refusable else (0, 1, 2, 4)
    good = used.exit in expected and told and not innocent and not (usable and z > BEYOND)
    line = next((row for row in reversed(text.splitlines()) if row.startswith(('TRUSTED', 'PARTIAL', 'REFUSED', 'FAILED', 'BAD INPUT', 'calibrate:'))),
                '')
    return {'drive': fault.drive, 'fault': fault.name, 'commit': commit, 'good': 'yes' if good else 'no',
            'verdict': verdict, 'exit': used.exit, 'lost': ' '.join(lost), 'worst_z': f'{z:.1f}' if usable else '',
            'parameter': worst['parameter'] if worst and usable else '', 'told': 'yes' if told else 'no',
            'cpu_s': f'{used.cpu:.0f}', 'line': line.replace(',', ';').replace('"', "'")[:200]}


def done_in(path):
    if not path.exists():
        return set()
    with open(path, newline='') as file:
        return {(line['drive'], line['fault']) for line in csv.DictReader(file)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--build', type=pathlib.Path, default=REPOSITORY / 'build', help='of the programs')
    parser.add_argument('--only', help='names of faults; default: all')
    parser.add_argument('--threads', type=int, default=1)
    parser.add_argument('--commit', help='of the programs; default: that of the directory the build lies in')
    parser.add_argument('--rows', type=pathlib.Path, help='CSV file that rows are added to')
    arguments = parser.parse_args()
    programs = arguments.build.resolve() / 'devel/lib/mlic'
    commit = arguments.commit or commit_of(arguments.build.resolve().parent)
    path = arguments.rows or HERE / 'results' / f'{commit}.csv'
    only = arguments.only.split(',') if arguments.only else [fault.name for fault in faults.FAULTS]
    unknown = set(only) - {fault.name for fault in faults.FAULTS}
    if unknown:
        sys.exit(f'run.py: no fault {", ".join(sorted(unknown))}; faults.py lists them')
    done = done_in(path)
    failed = 0
    with tempfile.TemporaryDirectory(prefix='mlic_faults_') as top:
        for fault in faults.FAULTS:
            if fault.name not in only or (fault.drive, fault.name) in done:
                continue
            sound = pathlib.Path(top) / fault.drive
            if not sound.exists():
                simulate(programs / 'simulate', fault.drive, sound)
            with tempfile.TemporaryDirectory(prefix='fault_', dir=top) as folder:
                line = measure(programs / 'calibrate', sound, fault, commit, pathlib.Path(folder), arguments.threads)
            append_rows(path, COLUMNS, [line])
            failed += line['good'] == 'no'
            print(f'{fault.drive}, {fault.name}: {"good" if line["good"] == "yes" else "BAD"}, {line["verdict"]}, exit '
                  f'{line["exit"]}, lost: {line["lost"] or "none"}, worst z {line["worst_z"] or "-"}, {line["cpu_s"]} s; '
                  f'{line["line"]}', flush=True)
    print(f'run.py: {failed} of the faults run now came out bad; rows in {path}')


if __name__ == '__main__':
    main()
