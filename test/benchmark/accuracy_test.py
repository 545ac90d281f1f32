#!/usr/bin/python3
"""Tests of the accuracy benchmark's statistics, rows and comparison; no drive is simulated.

usage: accuracy_test.py BENCHMARK_DIRECTORY
"""

import contextlib
import csv
import io
import itertools
import pathlib
import shutil
import sys
import tempfile
import unittest

BENCHMARK = pathlib.Path(sys.argv.pop(1))
sys.path.insert(0, str(BENCHMARK))

import compare
import gate
import paired
import report
import row
import run
import scenarios
from page import replace_section

TRUTH = """verdict: trusted
sensors:
  front:
    type: lidar
    observable: {translation: [true, true, true], rotation: [true, true, true], time_offset: true}
  left:
    type: camera
    observable: {translation: [true, true, true], rotation: [true, true, true], time_offset: true}
"""


def brute_force(differences):
    """p of the signed-rank test by counting all signs."""
    size = sorted(abs(value) for value in differences)
    rank = {value: sum(k + 1 for k, other in enumerate(size) if other == value) / size.count(value) for value in size}
    ranks = [rank[abs(value)] for value in differences]
    found = abs(sum(r if value > 0 else -r for r, value in zip(ranks, differences)))
    signs = list(itertools.product([1, -1], repeat=len(ranks)))
    return sum(abs(sum(s * r for s, r in zip(sign, ranks))) >= found for sign in signs) / len(signs)


class Statistics(unittest.TestCase):

    def test_signed_rank_is_the_exact_distribution(self):
        for differences in [[1, 2, 3, 4, 5, 6], [1, -2, 3, 4, -5, 6], [1, 1, -1, 2, 2, -3], [0.1, -7, 2, 2, 2, 5, -1]]:
            self.assertAlmostEqual(paired.signed_rank(differences), brute_force(differences), places=12)

    def test_no_difference_has_p_1(self):
        self.assertEqual(paired.signed_rank([0.0, 0.0]), 1.0)

    def test_holm_adjusts_by_the_number_of_tests(self):
        for found, expected in zip(paired.holm([0.01, 0.04, 0.03]), [0.03, 0.06, 0.06]):
            self.assertAlmostEqual(found, expected)


class Files(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix='mlic_accuracy_test_'))
        self.addCleanup(shutil.rmtree, self.folder)

    def rows(self, name, factor, verdict='trusted', count=20):
        path = self.folder / name
        for seed in range(count):
            run.append(path, {'scenario': 'gate', 'seed': seed, 'duration': 12, 'verdict': verdict, 'exit': 0,
                              'lost': 0, 'lidar_imu_rotation_deg': 0.001 * (1 + seed % 7) * factor ** (1 + seed % 3), 'cpu_s': 5,
                              'commit': 'abc', 'memory_mb': 100})
        return path

    def compare(self, a, b):
        argv, sys.argv = sys.argv, ['compare.py', str(a), str(b)]
        text = io.StringIO()
        try:
            with contextlib.redirect_stdout(text), self.assertRaises(SystemExit) as end:
                compare.main()
        finally:
            sys.argv = argv
        return end.exception.code, text.getvalue()

    def test_the_same_rows_do_not_differ(self):
        a = self.rows('a.csv', 1.0)
        self.assertEqual(self.compare(a, a)[0], 0)

    def test_larger_errors_and_lost_verdicts_fail(self):
        a, b = self.rows('a.csv', 1.0), self.rows('b.csv', 1.1)
        self.assertEqual(self.compare(a, b)[0], 1)
        status, text = self.compare(b, a)
        self.assertEqual(status, 0, text)
        self.assertIn('better', text)
        self.assertEqual(self.compare(a, self.rows('c.csv', 1.0, 'refused'))[0], 1)

    def test_three_pairs_prove_nothing(self):
        a, b = self.rows('a.csv', 1.0, count=3), self.rows('b.csv', 2.0, count=3)
        self.assertEqual(self.compare(a, b)[0], 0)

    def test_a_row_is_made_once(self):
        done = run.rows_done(self.rows('a.csv', 1.0))
        self.assertIn(('gate', 3, 12.0), done)
        self.assertEqual(run.rows_done(self.folder / 'none.csv'), set())

    def test_row_leaves_out_what_is_not_observable(self):
        (self.folder / 'truth.yaml').write_text(TRUTH)
        found = self.folder / 'calibration.yaml'
        found.write_text(TRUTH.replace('translation: [true, true, true]', 'translation: [true, true, false]', 1))
        columns = ['kind', 'name', 'rotation_deg', 'translation', 'time_offset', 'normalised_time_offset'] + [
            pattern.format(axis) for axis in 'xyz'
            for pattern in ('rotation_{}_deg', 'translation_{}', 'normalised_rotation_{}', 'normalised_translation_{}')]
        with open(self.folder / 'errors.csv', 'w', newline='') as file:
            writer = csv.DictWriter(file, columns)
            writer.writeheader()
            for name, error in [('front', 0.003), ('left', 0.004), ('front/left', 0.005)]:
                line = dict.fromkeys(columns, error)
                writer.writerow(dict(line, name=name, translation_z=7.0, normalised_translation_z=70.0))
        columns = row.errors_of(found, self.folder / 'truth.yaml', self.folder)
        self.assertEqual(columns['lost'], 0)
        self.assertAlmostEqual(float(columns['lidar_imu_translation_m']), 0.003 * 2 ** 0.5, places=6)
        self.assertEqual(columns['lidar_imu_translation_n'], 2)
        self.assertEqual(float(columns['lidar_camera_translation_z_worst']), 70.0)
        self.assertNotIn('camera_camera_rotation_deg', columns)

    def test_refused_without_a_file_loses_all_sensors(self):
        (self.folder / 'truth.yaml').write_text(TRUTH)
        columns = row.errors_of(self.folder / 'calibration.yaml', self.folder / 'truth.yaml', self.folder)
        self.assertEqual(columns, {'verdict': 'none', 'lost': 2})

    def test_report_replaces_its_own_section_only(self):
        page = self.folder / 'page.md'
        page.write_text('# Title\n\nbefore\n')
        with open(self.rows('a.csv', 1.0), newline='') as file:
            rows = list(csv.DictReader(file))
        replace_section(page, report.BEGIN, report.END, report.section(rows))
        page.write_text(page.read_text() + '\nafter\n')
        once = page.read_text()
        replace_section(page, report.BEGIN, report.END, report.section(rows))
        self.assertEqual(page.read_text(), once)
        self.assertIn('before', once)
        self.assertIn('| gate | LiDAR-IMU |', once)

    def test_gate_fails_on_verdict_and_on_sigmas(self):
        good = {'scenario': 'gate', 'seed': '1', 'verdict': 'trusted', 'exit': '0', 'lost': '0'}
        for quantity in row.QUANTITIES:
            good.update({f'lidar_imu_{quantity}_z_worst': '1.8', f'lidar_imu_{quantity}_z_rms': '1.0',
                         f'lidar_imu_{quantity}_n': '3'})
        self.assertEqual(gate.faults_of([good]), [])
        self.assertTrue(gate.faults_of([dict(good, verdict='refused')]))
        self.assertTrue(gate.faults_of([dict(good, lidar_imu_offset_z_worst='6')]))
        self.assertTrue(gate.faults_of([dict(good, lidar_imu_rotation_z_rms='3')]))

    def test_every_scenario_names_a_shipped_sensors_file(self):
        for scenario in scenarios.SCENARIOS:
            self.assertTrue((run.REPOSITORY / 'config/simulation' / scenario.sensors).exists(), scenario.sensors)


unittest.main()
