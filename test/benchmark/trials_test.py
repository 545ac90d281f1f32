#!/usr/bin/python3
"""Tests of the trials: what is drawn, how a result is scored, reported and compared; no drive is simulated.

usage: trials_test.py TRIALS_DIRECTORY
"""

import contextlib
import csv
import io
import math
import pathlib
import shutil
import sys
import tempfile
import unittest

sys.path.insert(0, sys.argv.pop(1))

import compare
import families
import first_sight
import report
import run
import score

SENSOR = """  {name}:
    type: {type}
    T_imu_sensor: {{translation: [{x}, 0.2, 0.3], rotation: [0, 0, {qz}, {qw}]}}
    sigma: {{translation: [0.001, 0.001, 0.002], rotation_deg: [0.01, 0.01, 0.02], time_offset: 0.0001}}
    bound: {{translation: [0.001, 0.0005, 0.001], rotation_deg: [0.01, 0.01, 0.02], time_offset: 0.00005}}
    observable: {{translation: [true, true, {z}], rotation: [true, true, true], time_offset: true}}
    time_offset: {offset}
"""
INTRINSICS = """    intrinsics: {{model: plumb_bob, image_size: [640, 480], params: [{f}, 400, 320, 240, -0.1, 0.01, 0, 0, 0]}}
    intrinsics_sigma: [0.1, 0.1, 0.2, 0.2, 0.001, 0.001, 0, 0, 0]
"""
PAIR = """pairs:
  front/left: {{T_a_b: {{translation: [{x}, 0, 0], rotation: [0, 0, 0, 1]}}, sigma: {{translation: [0.001, 0.001, 0.001], rotation_deg: [0.01, 0.01, 0.01], time_offset: 0.0002}}}}
"""


def yaml_of(x=0.1, yaw_deg=0.0, offset=0.01, z='true', f=400.0, pair_x=0.5, verdict='trusted'):
    half = math.radians(yaw_deg) / 2
    values = {'x': x, 'qz': math.sin(half), 'qw': math.cos(half), 'offset': offset, 'z': z}
    return (f'verdict: {verdict}\nsensors:\n' + SENSOR.format(name='front', type='lidar', **values) +
            SENSOR.format(name='left', type='camera', **dict(values, x=0.1, qz=0, qw=1, offset=0.01)) +
            INTRINSICS.format(f=f) + PAIR.format(x=pair_x))


IDENTITY = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]


class Axes(unittest.TestCase):

    def test_truth_turns_about_held_axes_only(self):
        """About z the result has the accelerometer's axes, about x the gyroscope's."""
        turned = families.rotation([0, 0, 1], math.radians(3))
        true = {'imu': {'accelerometer_matrix': turned, 'gyroscope_matrix': IDENTITY},
                'sensors': {'front': {'T_imu_sensor': {'translation': [1.0, 0.0, 0.0], 'rotation': [0.0, 0.0, 0.0, 1.0]}}}}
        imu = {'axes': 'gyroscope', 'alignment': {'of_accelerometer': [[1.0, 0.0, 0.0]]},
               'accelerometer_matrix': IDENTITY}
        score.in_axes_of(imu, true)
        pose = true['sensors']['front']['T_imu_sensor']
        self.assertAlmostEqual(pose['translation'][1], 0.0)
        imu['alignment']['of_accelerometer'] = [[0.0, 0.0, 1.0]]
        score.in_axes_of(imu, true)
        self.assertAlmostEqual(pose['translation'][1], math.sin(math.radians(3)))
        self.assertAlmostEqual(score.rotation_vector(pose['rotation'], [0.0, 0.0, 0.0, 1.0])[2], 3.0)

    def test_truth_turns_with_its_gyroscope(self):
        """Both of the IMU's sensors are turned against the axes that the truth is in, and sheared."""
        turned, triangle = families.rotation([0, 0, 1], math.radians(3)), [[1.01, 0, 0], [0.02, 0.99, 0], [-0.01, 0.03, 1]]
        matrix = sum(score.times(triangle, score.rows_of(turned)), [])
        true = {'imu': {'accelerometer_matrix': turned, 'gyroscope_matrix': matrix},
                'sensors': {'front': {'T_imu_sensor': {'translation': [1.0, 0.0, 0.0], 'rotation': [0.0, 0.0, 0.0, 1.0]}}}}
        score.in_axes_of({'axes': 'gyroscope', 'accelerometer_matrix': IDENTITY}, true)
        pose = true['sensors']['front']['T_imu_sensor']
        self.assertAlmostEqual(pose['translation'][1], math.sin(math.radians(3)))
        self.assertAlmostEqual(score.rotation_vector(pose['rotation'], [0.0, 0.0, 0.0, 1.0])[2], 3.0)


class Folder(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='mlic_trials_test_'))
        self.addCleanup(shutil.rmtree, self.folder)

    def scored(self, **changes):
        (self.folder / 'truth.yaml').write_text(yaml_of())
        (self.folder / 'calibration.yaml').write_text(yaml_of(**changes))
        rows, verdict, lost = score.score(self.folder / 'calibration.yaml', self.folder / 'truth.yaml')
        return {line['parameter']: line for line in rows}, verdict, lost


class Score(Folder):

    def test_the_truth_has_no_error(self):
        rows, verdict, lost = self.scored()
        self.assertEqual((verdict, lost), ('trusted', 0))
        self.assertEqual({float(line['worst_z']) for line in rows.values()}, {0.0})
        self.assertEqual(rows['lidar_imu_rotation']['n'], 3)
        self.assertEqual(rows['lidar_imu_offset']['n'], 1)
        self.assertEqual(rows['lidar_camera_translation']['n'], 3)
        self.assertEqual(rows['camera_distortion']['n'], 2, 'held coefficients have no sigma')

    def test_errors_and_sigmas_of_each_kind(self):
        rows, _, _ = self.scored(x=0.103, yaw_deg=-0.05, offset=0.0096, f=400.15, pair_x=0.5)
        translation = rows['lidar_imu_translation']
        self.assertAlmostEqual(float(translation['worst_z']), 3.0, places=3)
        self.assertAlmostEqual(float(translation['squares']), 9.0, places=2)
        self.assertEqual(translation['inside'], 2)
        self.assertAlmostEqual(float(translation['error']), 0.003, places=6)
        self.assertAlmostEqual(float(translation['sigma']), math.sqrt(6) / 1000, places=5)
        self.assertAlmostEqual(float(translation['bound']), 1.5 / 1000, places=6)
        self.assertEqual(rows['lidar_camera_translation']['bound'], '', 'the file has none of the pair')
        # 0.05 deg about z, whose sigma is 0.02 deg.
        self.assertAlmostEqual(float(rows['lidar_imu_rotation']['worst_z']), 2.5, places=3)
        self.assertAlmostEqual(float(rows['lidar_imu_rotation']['error']), 0.05, places=5)
        self.assertAlmostEqual(float(rows['lidar_imu_offset']['worst_z']), 4.0, places=3)
        # The pair's offset is that of its sensors, with the pair's sigma.
        self.assertAlmostEqual(float(rows['lidar_camera_offset']['worst_z']), 2.0, places=3)
        self.assertAlmostEqual(float(rows['camera_focal']['worst_z']), 1.5, places=3)
        self.assertEqual(float(rows['camera_imu_translation']['worst_z']), 0.0)

    def test_large_rotations_and_either_sign_of_a_quaternion(self):
        self.assertAlmostEqual(score.rotation_vector([0, 0, 1, 0], [0, 0, 0, 1])[2], 180.0)
        half = math.radians(0.1) / 2
        for sign in (1, -1):
            turned = [sign * math.sin(half), 0, 0, sign * math.cos(half)]
            self.assertAlmostEqual(score.rotation_vector(turned, [0, 0, 0, 1])[0], 0.1, places=9)

    def test_what_is_not_observable_is_left_out(self):
        rows, _, _ = self.scored(z='false')
        self.assertEqual(rows['lidar_imu_translation']['n'], 2)
        self.assertEqual(rows['lidar_imu_rotation']['n'], 3)
        self.assertNotIn('lidar_camera_translation', rows)

    def test_pairs_that_are_not_tied_to_the_imu_are_judged(self):
        found = yaml_of(pair_x=0.503, verdict='partial')
        found = found.replace('    type: lidar\n', '    type: lidar\n    verdict: rejected\n')
        found = found.replace('    type: camera\n', '    type: camera\n    verdict: rejected\n')
        found = found.replace('    time_offset: 0.01\n', '')
        for held, expected in (('[]', 3.0), ('[{quantity: translation, direction: [1, 0, 0], sigma: 0.1}]', None)):
            (self.folder / 'found.yaml').write_text(
                found.replace('time_offset: 0.0002}}', 'time_offset: 0.0002}, unobservable: ' + held + '}'))
            (self.folder / 'truth.yaml').write_text(yaml_of())
            rows, verdict, lost = score.score(self.folder / 'found.yaml', self.folder / 'truth.yaml')
            rows = {line['parameter']: line for line in rows}
            self.assertEqual((verdict, lost), ('partial', 2))
            self.assertNotIn('lidar_imu_rotation', rows)
            self.assertNotIn('lidar_camera_offset', rows)
            self.assertEqual(float(rows['lidar_camera_rotation']['worst_z']), 0.0)
            if expected is None:
                self.assertNotIn('lidar_camera_translation', rows)
            else:
                self.assertAlmostEqual(float(rows['lidar_camera_translation']['worst_z']), expected, places=3)

    def test_no_file_loses_all_sensors(self):
        (self.folder / 'truth.yaml').write_text(yaml_of())
        self.assertEqual(score.score(self.folder / 'none.yaml', self.folder / 'truth.yaml'), ([], 'none', 2))


class Draw(unittest.TestCase):

    def test_seeds_decide_and_effects_leave_the_rest(self):
        for kind in families.KINDS:
            for split in ('open', 'closed'):
                a = families.draw_trial(kind, 5, split)
                self.assertEqual(a, families.draw_trial(kind, 5, split))
                self.assertNotEqual(a, families.draw_trial(kind, 6, split))
                for effect in families.EFFECTS:
                    b = families.draw_trial(kind, 5, split, effect)
                    self.assertEqual(a['world_seed'], b['world_seed'])
                    self.assertEqual(a['sensors']['imu']['rate'], b['sensors']['imu']['rate'])

    def test_open_and_closed_families_share_no_world_and_are_all_drawn(self):
        self.assertFalse(set(families.OPEN) & set(families.CLOSED))
        for split, expected in [('open', families.OPEN), ('closed', families.CLOSED)]:
            trials = [families.draw_trial('lidar', seed, split) for seed in range(40)]
            self.assertEqual({trial['world'] for trial in trials}, set(expected))
            for trial in trials:
                if trial['world'] in families.BY_HAND_ONLY:
                    self.assertIn('handheld', trial['motion'])

    def test_effects_change_the_sensors(self):
        plain = families.draw_trial('lidar', 3, 'open')
        turned = families.draw_trial('lidar', 3, 'open', 'accelerometer_turned_3')
        matrix = turned['sensors']['imu']['accelerometer_matrix']
        self.assertAlmostEqual(math.degrees(math.acos((matrix[0] + matrix[4] + matrix[8] - 1) / 2)), 3.0, places=6)
        self.assertNotIn('accelerometer_matrix', plain['sensors']['imu'])
        biased = families.draw_trial('lidar', 3, 'open', 'ring_bias')
        for lidar in biased['sensors']['lidars'].values():
            self.assertEqual(len(lidar['ring_bias']), families.rings_of(lidar['pattern']))


class Rows(Folder):

    def rows(self, name, factor=1.0, z=1.0, verdict='trusted', effect='none', count=20):
        path = self.folder / name
        for seed in range(count):
            trial = dict(families.draw_trial('lidar', seed, 'open'), effect=effect, commit='abc', verdict=verdict, exit=0,
                         lost=0, cpu_s=1)
            of_trial = {column: trial[column] for column in score.TRIAL if column != 'guess'}
            lines = [dict(of_trial, parameter=parameter, n=3, error=0.001 * (1 + seed % 7) * factor ** (1 + seed % 3), sigma=0.001,
                          squares=3 * z * z, inside=3 if z < 1.96 else 0, worst_z=z)
                     for parameter in ('lidar_imu_rotation', 'lidar_imu_translation')]
            run.append(path, lines)
        return path

    def compare(self, *arguments):
        argv, sys.argv = sys.argv, ['compare.py', *map(str, arguments)]
        text = io.StringIO()
        try:
            with contextlib.redirect_stdout(text), self.assertRaises(SystemExit) as end:
                compare.main()
        finally:
            sys.argv = argv
        return end.exception.code, text.getvalue()

    def test_a_drive_is_made_once(self):
        done = run.done_in(self.rows('a.csv', count=3))
        self.assertEqual(done, {('lidar', 'open', seed, 'none') for seed in range(3)})
        self.assertEqual(run.done_in(self.folder / 'none.csv'), set())
        self.assertEqual(run.seeds_of('1-3,7'), [1, 2, 3, 7])

    def test_report_counts_verdicts_and_squares(self):
        rows = report.load([self.rows('a.csv', z=2.0, count=8), self.rows('b.csv', z=9.0, verdict='refused', count=1)])
        for line in rows[16:]:
            line['seed'] = '99'
        text = report.report(rows)
        self.assertIn('| open | all | 9 | 8 | 0 | 1 | 0 | 0 | 0 | 2.0 |', text)
        self.assertIn('4.00 [4.00, 4.00] of 24 | 0% | 2.0 |', text)
        self.assertIn('Nothing given is beyond 4 sigmas', text)
        worse = report.load([self.rows('c.csv', z=6.0, count=1)])
        self.assertIn('| open | all | 1 | 1 | 0 | 0 | 0 | 1 | 0 | 6.0 |', report.report(worse))
        partial = report.load([self.rows('d.csv', z=6.0, verdict='partial', count=1)])
        self.assertIn('| open | all | 1 | 0 | 1 | 0 | 0 | 1 | 0 | 6.0 |', report.report(partial))
        self.assertIn('| 6.0 | lidar_imu_rotation |', report.report(worse))

    def test_first_sight_has_each_drive_once(self):
        rows = report.load([self.rows('a.csv', count=3)])
        self.assertIn('**LiDARs and IMU** (seeds open 0-2):', first_sight.section(rows))
        self.assertEqual(first_sight.runs_of_seeds([{'seed': '7'}, {'seed': '3'}, {'seed': '2'}, {'seed': '7'}]), '2-3, 7')
        with self.assertRaisesRegex(SystemExit, '1 drives of lidar are there more than once'):
            first_sight.section(rows + [dict(rows[0], commit='later')])

    def test_bootstrap_is_over_drives(self):
        mean, low, high = report.mean_square_interval([(0.0, 3)] * 10 + [(12.0, 3)] * 10)
        self.assertAlmostEqual(mean, 2.0)
        # 20 draws of 0 or 4: standard deviation 2/sqrt(20).
        self.assertAlmostEqual(high - low, 2 * 1.96 * 2 / math.sqrt(20), delta=0.35)

    def test_compare_pairs_by_drive(self):
        a = self.rows('a.csv')
        self.assertEqual(self.compare(a, a)[0], 0)
        self.assertEqual(self.compare(a, self.rows('b.csv', factor=1.1))[0], 1)
        self.assertEqual(self.compare(self.rows('b2.csv', factor=1.1), a)[0], 0)
        self.assertEqual(self.compare(a, self.rows('c.csv', verdict='refused'))[0], 1)
        status, text = self.compare(a, self.rows('d.csv', z=6.0))
        self.assertEqual(status, 1)
        self.assertIn('trusted at 6.0 sigmas, before 1.0', text)

    def test_effects_pair_only_when_asked(self):
        a, b = self.rows('a.csv'), self.rows('b.csv', effect='rain')
        with contextlib.redirect_stderr(io.StringIO()):
            self.assertEqual(self.compare(a, b)[0], 2)
        self.assertEqual(self.compare(a, b, '--across-effects')[0], 0)


unittest.main()
