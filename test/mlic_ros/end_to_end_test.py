#!/usr/bin/python3
"""Runs simulate and calibrate as a user does and looks at exit status, files and errors against the truth.

usage: end_to_end_test.py PROGRAM_DIRECTORY REPOSITORY
"""

import csv
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

import yaml

PROGRAMS = pathlib.Path(sys.argv[1])
REPOSITORY = pathlib.Path(sys.argv[2])


def run(program, *arguments):
    return subprocess.run([str(PROGRAMS / program), *map(str, arguments)], capture_output=True, text=True)


class EndToEnd(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='mlic_end_to_end_'))
        self.addCleanup(shutil.rmtree, self.folder)

    def simulate(self, scenario, duration, *arguments):
        drive = self.folder / f'{scenario}.bag'
        done = run('simulate', '--sensors', REPOSITORY / 'config/simulation/handheld.yaml', '--scenario', scenario,
                   '--duration', duration, '--seed', 7, '--output', drive, *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return drive, self.folder / f'{scenario}_rig.yaml', self.folder / f'{scenario}_truth.yaml'

    def calibrate(self, drive, rig):
        output = self.folder / 'calibration'
        return run('calibrate', '--rig', rig, '--bag', drive, '--output', output), output

    def test_excited_motion_is_calibrated_without_a_guess(self):
        drive, rig, truth = self.simulate('handheld', 25, '--no-guess')
        done, output = self.calibrate(drive, rig)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for name in ['calibration.yaml', 'static_transforms.launch', 'sensors.urdf.xacro', 'sensors_macro.xacro',
                     'trajectory.tum', 'map.pcd', 'report.html', 'log.txt']:
            self.assertGreater((output / name).stat().st_size, 0, name)
        calibration = yaml.safe_load((output / 'calibration.yaml').read_text())
        self.assertEqual(calibration['format'], 'mlic_calibration/1')
        self.assertEqual(calibration['verdict'], 'trusted')
        self.check_evaluation(drive, output, rig, truth)
        urdf = subprocess.run(['check_urdf', output / 'sensors.urdf.xacro'], capture_output=True, text=True)
        self.assertEqual(urdf.returncode, 0, urdf.stdout + urdf.stderr)
        launch = xml.etree.ElementTree.parse(output / 'static_transforms.launch').getroot()
        self.assertEqual([node.get('pkg') for node in launch.iter('node')], ['tf2_ros'])

    def check_evaluation(self, drive, calibration, rig, truth):
        output = self.folder / 'evaluation'
        arguments = ['--bag', drive, '--calibration', calibration / 'calibration.yaml', '--output', output]
        done = run('evaluate', *arguments, '--truth', truth, '--method', 'hand_eye', '--rig', rig)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertEqual((output / 'evaluation.txt').read_text(), done.stdout)
        with (output / 'errors.csv').open() as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 1)
        self.assertLess(float(rows[0]['rotation_deg']), 0.03)
        self.assertLess(math.hypot(*(float(rows[0][f'translation_{axis}']) for axis in 'xyz')), 0.008)
        self.assertLess(abs(float(rows[0]['time_offset'])), 1e-4)
        entropies = []
        for name in ['map_quality.csv', 'map_quality_truth.csv']:
            with (output / name).open() as file:
                entropies.append(float(next(row['value'] for row in csv.DictReader(file) if row['name'] == 'all')))
        self.assertLess(abs(entropies[0] - entropies[1]), 0.05, 'the map is as crisp as with the true calibration')
        with (output / 'methods.csv').open() as file:
            methods = {row['method']: float(row['rotation_deg']) for row in csv.DictReader(file)}
        self.assertEqual(list(methods), ['joint', 'hand_eye'])
        self.assertLess(methods['joint'], methods['hand_eye'])
        self.assertLess(methods['hand_eye'], 0.5)
        done = run('evaluate', '--calibration', output / 'hand_eye.yaml', output / 'hand_eye.yaml', '--truth', truth,
                   '--output', self.folder / 'hand_eye')
        self.assertEqual(done.returncode, 0, 'a rival is a calibration file like others: ' + done.stderr)
        # Without a truth the old comparison goes; bad input is one line, and nothing is written.
        self.assertEqual(run('evaluate', *arguments).returncode, 0)
        self.assertFalse((output / 'errors.csv').exists())
        shutil.rmtree(output)
        for bad, part in [(['--reference-topic', '/not/there'], '/not/there'),
                          (['--reference-topic', '/imu/data'], 'nav_msgs/Odometry'),
                          (['--method', 'pairwise'], '--rig'),
                          (['--truth', self.folder / 'none.yaml'], 'none.yaml')]:
            done = run('evaluate', *arguments, *bad)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(part, done.stderr)
            self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        (calibration / 'trajectory.tum').unlink()
        done = run('evaluate', *arguments)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn('trajectory.tum', done.stderr)
        self.assertFalse(output.exists())

    def test_a_parked_vehicle_is_refused(self):
        drive, rig, _ = self.simulate('static', 10)
        done, output = self.calibrate(drive, rig)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        calibration = yaml.safe_load((output / 'calibration.yaml').read_text())
        self.assertEqual(calibration['verdict'], 'refused')
        self.assertTrue(calibration['reasons'])
        self.assertFalse((output / 'static_transforms.launch').exists())
        self.assertFalse((output / 'sensors.urdf.xacro').exists())

    def test_a_missing_topic_is_named_and_nothing_is_written(self):
        drive, rig, _ = self.simulate('static', 3)
        text = rig.read_text()
        topic = yaml.safe_load(text)['imu']['topic']
        rig.write_text(text.replace(topic, '/not/there'))
        done, output = self.calibrate(drive, rig)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertIn('/not/there', done.stderr)
        self.assertIn(topic, done.stderr)
        self.assertFalse((output / 'calibration.yaml').exists())


unittest.main(argv=sys.argv[:1], verbosity=2)
