#!/usr/bin/python3
"""fleet with a program that takes the place of calibrate, here and by a program that takes the place of Slurm's sbatch.

usage: fleet_test.py PROGRAM_DIRECTORY
"""
import csv
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

RIG = "imu: {topic: /imu/data}\nlidars:\n  one: {topic: /velodyne_points}\n"
# What the drive's bag says it shall do: the x of the LiDAR and the verdict, or "wait" or "fail".
CALIBRATE = """#!/usr/bin/python3
import os, signal, sys, time
arguments = dict(zip(sys.argv[1::2], sys.argv[2::2]))
print(' '.join(sys.argv[1:]))
x, verdict = open(arguments['--bag']).read().split()
if verdict == 'wait':
    print('waiting', flush=True)
    signal.pause()
if verdict == 'fail':
    sys.exit('BAD INPUT: no topic /imu/data\\nlog: none\\nto do: mend it')
os.makedirs(arguments['--output'])
open(arguments['--output'] + '/manifest.txt', 'w').write('mlic output of calibrate\\n')
reasons = "['too little motion']" if verdict == 'refused' else '[]'
sensors = 'sensors: {}' if verdict == 'refused' else f'''
sensors:
  one:
    type: lidar
    frame_id: velodyne
    T_imu_sensor: {{translation: [{x}, 0.0, 0.0], rotation: [0, 0, 0, 1]}}
    sigma: {{translation: [0.001, 0.001, 0.001], rotation_deg: [0.01, 0.01, 0.01], time_offset: 0.0001}}
    time_offset: 0.01
'''
open(arguments['--output'] + '/calibration.yaml', 'w').write(
    f'format: mlic_calibration/1\\nverdict: {verdict}\\nreasons: {reasons}\\nimu: {{frame_id: imu_link}}\\n{sensors}')
sys.exit({'trusted': 0, 'refused': 2}[verdict])
"""
# Runs the tasks of the array one after another, as sbatch --wait does.
SBATCH = """#!/bin/bash
echo "4711;cluster"
last=$(sed -n 's/^#SBATCH --array=0-//p' "${@: -1}")
for task in $(seq 0 "$last"); do SLURM_ARRAY_TASK_ID=$task SLURM_CPUS_ON_NODE=3 bash "${@: -1}"; done
"""


class Fleet(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "with a blank"
        self.folder.mkdir()
        shutil.copy(PROGRAMS / "fleet", self.folder)
        self.program("calibrate", CALIBRATE)
        (self.folder / "rig.yaml").write_text(RIG)

    def program(self, name, text):
        (self.folder / name).write_text(text)
        (self.folder / name).chmod(0o755)

    def command(self, *more, **drives):
        for name, does in drives.items():
            (self.folder / (name + ".bag")).write_text(does)
        (self.folder / "list.txt").write_text("".join(name + ".bag\n" for name in drives))
        return [self.folder / "fleet", "--bags", self.folder / "list.txt", "--rig", self.folder / "rig.yaml",
                "--output", self.folder / "out", *more]

    def run_fleet(self, *more, **drives):
        return subprocess.run(self.command(*more, **drives), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, timeout=60,
                              env=dict(os.environ, PATH=f"{self.folder}:{os.environ['PATH']}"))

    def rows(self):
        with open(self.folder / "out" / "fleet.csv") as file:
            return {row["drive"]: row for row in csv.DictReader(file)}

    def test_drives_that_agree(self):
        done = self.run_fleet("--at-once", "2", "--threads", "1", monday="1.0 trusted", friday="1.0012 trusted")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("fleet: 2 of 2 drives: ", done.stderr)
        self.assertIn("errors agree with the claims: worst 0.8 sigma (one, translation x)", done.stdout)
        self.assertIn("2 of 2 drives are trusted, 0 partial", done.stdout)
        self.assertEqual({row["verdict"] for row in self.rows().values()}, {"trusted"})
        with open(self.folder / "out" / "repeatability.csv") as file:
            self.assertEqual([row["n"] for row in csv.DictReader(file)], ["2"])

    def test_drives_that_do_not_give_all(self):
        done = self.run_fleet("--", "--duration", "60", good="1.0 trusted", parked="0.0 refused", other="0.0 fail")
        self.assertEqual(done.returncode, 4, done.stderr)
        rows = self.rows()
        self.assertEqual([rows[name]["verdict"] for name in ("good", "parked", "other")], ["trusted", "refused", "none"])
        self.assertIn("REFUSED: too little motion", rows["parked"]["line"])
        self.assertIn("BAD INPUT: no topic /imu/data (log: ", rows["other"]["line"])
        self.assertIn("--duration 60", (self.folder / "out" / "logs" / "good.txt").read_text())
        self.assertFalse((self.folder / "out" / "repeatability.csv").exists())
        self.assertEqual(self.run_fleet(other="0.0 fail").returncode, 2, "the same list with no drive that gives any")

    def test_interruption_reaches_the_drives(self):
        fleet = subprocess.Popen(self.command(one="0.0 wait", two="0.0 wait"), stderr=subprocess.PIPE)
        log = self.folder / "out" / "logs" / "one.txt"
        while not log.exists() or "waiting" not in log.read_text():
            self.assertIsNone(fleet.poll())
        fleet.send_signal(signal.SIGINT)
        _, said = fleet.communicate(timeout=60)
        self.assertEqual(fleet.returncode, 130, said)
        self.assertIn("KeyboardInterrupt", log.read_text())
        self.assertFalse((self.folder / "out" / "logs" / "two.txt").exists())

    def test_slurm(self):
        self.program("sbatch", SBATCH)
        done = self.run_fleet("--slurm", "--threads", "3", **{"a b": "1.0 trusted", "it's": "1.0 trusted", "no": "0 fail"})
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("fleet: 3 of 3 drives", done.stderr)
        self.assertIn("2 of 3 drives are trusted", done.stdout)
        self.assertIn("--threads 3", (self.folder / "out" / "logs" / "it's.txt").read_text())
        script = (self.folder / "out" / "slurm.sh").read_text()
        self.assertIn("#SBATCH --cpus-per-task=3\n", script)
        for line in script.splitlines():  # sbatch takes blanks there for the end of a word
            self.assertRegex(line, "^(?!#SBATCH)|^#SBATCH \\S+$")

    def test_slurm_that_ends_a_drive_or_takes_none(self):
        self.program("sbatch", "#!/bin/sh\necho 4711\n")
        done = self.run_fleet("--slurm", one="1.0 trusted")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("one: FAILED: ended without a word", done.stdout)
        self.program("sbatch", "#!/bin/sh\necho 'sbatch: error: invalid partition' >&2\nexit 1\n")
        done = self.run_fleet("--slurm", one="1.0 trusted")
        self.assertEqual(done.returncode, 1)
        self.assertIn("sbatch: error: invalid partition; expected a job's number", done.stderr)

    def test_bad_input_is_said_once_and_before_all_work(self):
        (self.folder / "rig.yaml").write_text(RIG + "cammeras: {}\n")
        done = self.run_fleet(one="1.0 trusted")
        self.assertEqual((done.returncode, done.stderr.count("\n")), (1, 1), done.stderr)
        self.assertIn("cammeras", done.stderr)
        self.assertFalse((self.folder / "out").exists())


if __name__ == "__main__":
    PROGRAMS = pathlib.Path(sys.argv.pop(1))
    unittest.main()
