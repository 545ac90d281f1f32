#!/usr/bin/python3
"""Exit statuses and messages of the installed programs: ros_programs_test.py PROGRAM_DIRECTORY [DRIVE.bag RIG.yaml]."""
import csv
import fcntl
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import rosbag
import yaml

CALIBRATION = """format: mlic_calibration/1
imu: {frame_id: imu_link}
sensors:
  lidar: {type: lidar, frame_id: velodyne, T_imu_sensor: {translation: [1, 2, 3], rotation: [0, 0, 0, 1]}, time_offset: 0.01}
"""
CAMERA = """{T_imu_sensor: {xyz: [0, 0, 0]}, fov_deg: 90, model: plumb_bob, image_size: [320, 240],
        intrinsics: [160, 160, 159.5, 119.5, -0.1, 0.02, 0, 0, 0]}"""
ROBOT = """<robot name="r">
  <link name="base_link"/> <!-- ours -->
  <link name="imu_link"/>
  <joint name="j" type="fixed"><parent link="base_link"/><child link="imu_link"/><origin xyz="10 0 0"/></joint>
</robot>
"""
RIG = "imu: {topic: /imu/data}\nlidars:\n  one: {topic: /velodyne_points}\n"


class Programs(unittest.TestCase):
    finished = None  # the run of calibrate on the drive, and its output directory

    @classmethod
    def tearDownClass(cls):
        if cls.finished:
            cls.finished[1].cleanup()

    def take_finished(self):
        """The results of one run on the drive, which the tests share, in this one's output directory; its process."""
        if not Programs.finished:
            folder = tempfile.TemporaryDirectory()
            Programs.finished = (self.run_program("calibrate", "--rig", DRIVE[1], "--bag", DRIVE[0], "--output",
                                                  os.path.join(folder.name, "out")), folder)
        done, folder = Programs.finished
        self.assertEqual(done.returncode, 0, done.stderr)
        shutil.copytree(os.path.join(folder.name, "out"), self.output)
        return done

    def begin(self, *more):
        """calibrate on the drive, while it works."""
        return subprocess.Popen([os.path.join(PROGRAMS, "calibrate"), "--rig", DRIVE[1], "--bag", DRIVE[0], "--output",
                                 self.output, *more], stderr=subprocess.PIPE, universal_newlines=True)

    def lines_until(self, process, last):
        lines = []
        for line in process.stderr:
            lines.append(line)
            if last(line):
                break
        return lines

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.output = self.path("out")

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def run_program(self, name, *arguments):
        return subprocess.run([os.path.join(PROGRAMS, name), *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600)

    def expect_error(self, done, *parts):
        """Status 1, and the last line on stderr holds all the parts."""
        self.assertEqual(done.returncode, 1, done.stderr)
        lines = [line for line in done.stderr.splitlines() if not line.startswith("[loading]")]
        self.assertEqual(len(lines), 1, done.stderr)
        for part in parts:
            self.assertIn(part, lines[0])

    def expect_end(self, done, status, *parts):
        """The last three lines of calibrate: reason, where the log lies, what to do, each with its part."""
        self.assertEqual(done.returncode, status, done.stderr)
        lines = done.stderr.splitlines()
        self.assertEqual([line.split(":")[0] for line in lines[-2:]], ["log", "to do"], done.stderr)
        for line, part in zip(lines[-3:], parts):
            self.assertIn(part, line)
        return lines

    def calibrate(self, rig, bag, *more):
        return self.run_program("calibrate", "--rig", rig, "--bag", bag, "--output", self.output, *more)

    def expect_nothing_but_the_log(self):
        self.assertLessEqual(set(os.listdir(self.output)), {".mlic_lock", "log.txt", "manifest.txt", "stages"})

    def test_usage(self):
        self.expect_error(self.run_program("calibrate"), "calibrate", "required")
        self.expect_error(self.run_program("calibrate", "--frobnicate"), "calibrate")
        self.expect_error(self.run_program("inspect_bag"), "inspect_bag")
        self.expect_error(self.run_program("simulate", "--sensors", "none.yaml"), "simulate: --output is required")
        self.expect_error(self.run_program("calibrate", "--rig", "r", "--bag", "b", "--output", "o", "--add", "x"), "--prior")
        self.assertEqual(self.run_program("calibrate", "--help").returncode, 0)

    def test_missing_files(self):
        rig = self.write("rig.yaml", RIG)
        for missing, arguments in [("none.bag: no such file", (rig, self.path("none.bag"))),
                                   ("none.yaml", (self.path("none.yaml"), self.path("none.bag")))]:
            lines = self.expect_end(self.calibrate(*arguments), 1, missing, "log: none")
            self.assertEqual(len(lines), 3)
            self.assertFalse(os.path.exists(self.output))
        self.expect_error(self.run_program("inspect_bag", self.path("none.bag")), "none.bag", "no such file")
        self.expect_error(self.run_program("compare", rig, self.path("none.yaml")), "compare: ", rig)

    def test_export(self):
        calibration, robot = self.write("c.yaml", CALIBRATION), self.write("robot.urdf", ROBOT)

        def export(*arguments):
            return self.run_program("export", "--calibration", calibration, "--format", *arguments)

        about_imu = export("tf2")
        self.assertEqual(about_imu.returncode, 0, about_imu.stderr)
        self.assertRegex(about_imu.stdout, r'args="1\.0* 2\.0* 3\.0* 0\.0* 0\.0* 0\.0* 1\.0* imu_link velodyne"')
        about_base = export("tf2", "--parent", "base_link", "--urdf", robot)
        self.assertRegex(about_base.stdout, r'args="11\.0* 2\.0* 3\.0* .* base_link velodyne"')
        self.assertNotIn("imu_link", about_base.stdout, "the model publishes it")
        self.assertIn("imu is left out", about_base.stderr)
        merged = export("urdf", "--urdf", robot, "--output", robot)
        self.assertIn("imu_link stays where the model has it; updated: none; appended: velodyne", merged.stderr)
        with open(robot) as file:
            text = file.read()
        self.assertIn('<link name="base_link"/> <!-- ours -->', text)
        newer = self.write("newer.yaml", CALIBRATION.replace("calibration/1", "calibration/2"))
        self.expect_error(self.run_program("compare", newer, newer), "mlic_calibration/2", "newer MLIC", "mlic_calibration/1")
        self.assertIn('<child link="velodyne"/>', text)
        self.assertEqual(export("fast_lio", "--output", self.path("slam")).returncode, 0)
        self.assertEqual(os.listdir(self.path("slam")), ["lidar.yaml"])
        self.expect_error(export("tf2", "--parent", "base_link"), "--parent base_link", "imu_link, velodyne", "--urdf")
        self.expect_error(export("fast_lio"), "give a directory by --output")
        self.expect_error(export("kalibr"), "c.yaml: has no sensor that --format kalibr could hold", "camera")
        self.expect_error(export("kalibr", "--parent", "velodyne"), "leave out --parent")
        self.expect_error(export("pdf"), "pdf", "tf2")
        self.expect_error(export("tf2", "--velodyne", robot), "--velodyne belongs to --format rings")
        driver = self.write("vlp.yaml", "lasers:\n- {dist_correction: 0.5, vert_correction: 0.1}\n")
        self.expect_error(export("rings", "--velodyne", driver), "no corrections of any LiDAR")
        corrected = "time_offset: 0.01, corrections: {range_offset: 0.25, range_slope: 0, rings: []}}"
        self.write("c.yaml", CALIBRATION.replace("time_offset: 0.01}", corrected))
        self.expect_error(export("rings", "--velodyne", driver, "--lidar", "rear"), "no corrections of rear", "some of lidar")
        merged = export("rings", "--velodyne", driver)
        self.assertIn("- {dist_correction: 0.750000000, vert_correction: 0.1}", merged.stdout, merged.stderr)
        self.write("c.yaml", CALIBRATION.replace("imu:", "verdict: refused\nreasons: [parked]\nimu:"))
        self.expect_error(export("tf2"), "its verdict is refused", "parked")

    def test_calibration_harp(self):
        photos, evaluation = self.path("photos"), self.path("evaluation")
        sensors = self.write("sensors.yaml", f"imu: {{}}\ncameras:\n  one: {CAMERA}\n  two: {CAMERA}\n")
        done = self.run_program("simulate", "--sensors", sensors, "--harp", "--output", photos)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(os.listdir(photos)), ["manifest.txt", "one", "truth.yaml", "two"])

        def evaluate(calibration, *more, of="one"):
            return self.run_program("evaluate", "--calibration", calibration, "--harp", os.path.join(photos, of), "--output",
                                    evaluation, *more)

        truth = os.path.join(photos, "truth.yaml")
        done = evaluate(truth, "--camera", "one")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout.splitlines()[-1], "^one: straight edges are straight to .* within 0.5 px rms and 1.0 px$")
        self.assertEqual(sorted(os.listdir(evaluation)),
                         ["evaluation.txt", "harp.csv", "harp.png", "harp_histogram.csv", "manifest.txt"])
        with open(truth) as file:
            straight = self.write("straight.yaml", file.read().replace("-0.1", "0.0", 1))
        done = evaluate(straight, "--camera", "one", "--truth", truth)
        self.assertRegex(done.stdout.splitlines()[-1], "beyond 0.5 px rms and 1.0 px$")
        with open(os.path.join(evaluation, "harp.csv")) as file:
            rows = [row for row in csv.DictReader(file) if row["photo"] == "all"]
        self.assertEqual([row["intrinsics"] for row in rows], ["calibration", "truth"])
        self.assertGreater(float(rows[0]["rms_px"]), 10 * float(rows[1]["rms_px"]))

        self.expect_error(evaluate(truth), "which camera", "one, two")
        self.expect_error(evaluate(truth, "--camera", "three"), "--camera three", "one, two")
        self.expect_error(evaluate(truth, "--camera", "one", of="none"), "none: no such folder")
        self.expect_error(evaluate(truth, "--camera", "one", of="."), "holds no photo")
        self.expect_error(evaluate(truth, "--camera", "one", "--bag", "some.bag"), "--harp needs no --bag")
        with open(os.path.join(photos, "one", "11.png"), "w") as file:
            file.write("no photo")
        self.expect_error(evaluate(truth, "--camera", "one"), "11.png: cannot be read as an image")

    def test_unknown_key_names_the_line(self):
        rig = self.write("rig.yaml", RIG + "  two: {topic: /x, range: 5}\n")
        lines = self.expect_end(self.calibrate(rig, self.path("none.bag")), 1, "rig.yaml:4")
        self.assertIn("range", lines[0])
        self.assertFalse(os.path.exists(self.output))

    def test_output_that_cannot_be_made(self):
        rig = self.write("rig.yaml", RIG)
        self.output = os.path.join(self.write("file", ""), "out")
        self.expect_end(self.calibrate(rig, self.write("a.bag", "")), 1, "--output")

    def own_files(self):
        """An output directory with the user's own things, as path and content."""
        files = {"images/holiday.png": "x", "camera_info/mine.yaml": "x", "calibration.yaml": "mine", "log.txt": "mine"}
        for name, text in files.items():
            os.makedirs(os.path.dirname(os.path.join(self.output, name)), exist_ok=True)
            self.write(os.path.join("out", name), text)
        return files

    def read_output(self):
        read = {}
        for folder, _, names in os.walk(self.output):
            for name in names:
                path = os.path.join(folder, name)
                with open(path) as file:
                    read[os.path.relpath(path, self.output)] = file.read()
        return read

    def test_a_directory_with_other_files_is_refused_before_the_bag_is_read(self):
        rig, files = self.write("rig.yaml", RIG), self.own_files()
        self.expect_end(self.calibrate(rig, self.path("none.bag")), 1, "holds files that MLIC did not write", "log: none")
        self.assertEqual(self.read_output(), files)
        for program, arguments in [
                ("evaluate", ["--bag", self.path("none.bag"), "--calibration", self.path("none.yaml")]),
                ("register_pair", ["--cloud", self.path("none.pcd"), "--image", self.path("none.png"), "--rig", rig])]:
            done = self.run_program(program, *arguments, "--output", self.output)
            self.expect_error(done, "holds files that MLIC did not write")
            self.assertEqual(self.read_output(), files)

    def test_a_directory_in_use_names_the_process(self):
        os.mkdir(self.output)
        lock = open(os.path.join(self.output, ".mlic_lock"), "w")
        lock.write("12345")
        lock.flush()
        fcntl.flock(lock, fcntl.LOCK_EX)
        rig, bag = self.write("rig.yaml", RIG), self.write("a.bag", "text")
        self.expect_end(self.calibrate(rig, bag), 1, "in use by process 12345", "log: none")
        self.assertEqual(os.listdir(self.output), [".mlic_lock"])
        lock.close()
        self.expect_end(self.calibrate(rig, bag), 1, "a.bag", "log: " + os.path.join(self.output, "log.txt"))
        self.expect_nothing_but_the_log()

    def test_finished_results_are_reused(self):
        if not DRIVE:
            self.skipTest("no drive given")
        first = self.take_finished()
        before = os.stat(self.path("out/calibration.yaml")).st_mtime_ns
        again = self.calibrate(DRIVE[1], DRIVE[0])
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertIn("reused", again.stderr)
        last = again.stderr.splitlines()[-3:]
        for line, part in zip(last, ["TRUSTED: 2 sensors, worst sigma ", "report: " + self.path("out/report.html"),
                                     "use it: roslaunch " + self.path("out/static_transforms.launch")]):
            self.assertIn(part, line)
        self.assertEqual(first.stderr.splitlines()[-3], last[0])
        with open(self.path("out/calibration.yaml")) as file:
            run = yaml.safe_load(file)["run"]
        self.assertEqual([entry["path"] for entry in run["inputs"]], [os.path.abspath(path) for path in (DRIVE[1], DRIVE[0])])
        self.assertIn("calibrate --rig " + os.path.abspath(DRIVE[1]), run["command"])
        with open(self.path("out/log.txt")) as log:
            self.assertIn("round 1", log.read(), "the log of the run that did the work")
        self.assertEqual(os.stat(self.path("out/calibration.yaml")).st_mtime_ns, before)
        found, truth = self.path("out/calibration.yaml"), DRIVE[1].replace("_rig.yaml", "_truth.yaml")
        same = self.run_program("compare", found, found)
        self.assertEqual(same.returncode, 0, same.stderr)
        self.assertIn("AGREE: worst 0.0 sigma", same.stdout.splitlines()[-1])
        self.expect_error(self.run_program("compare", truth, truth), "compare", "claim no sigmas")
        self.assertIn("worst", self.run_program("compare", found, truth).stdout.splitlines()[-1])
        os.remove(self.path("out/calibration.yaml"))
        other = self.begin("--duration", "10")
        lines = self.lines_until(other, lambda line: "[LiDAR odometry]" in line)
        other.kill()
        other.communicate(timeout=60)
        self.assertIn("[LiDAR odometry]", lines[-1])
        self.assertNotIn("reused", "".join(lines))

    def test_a_sensor_is_added_to_those_of_a_prior(self):
        if not DRIVE:
            self.skipTest("no drive given")
        self.take_finished()
        with open(self.path("out/calibration.yaml")) as file:
            prior = yaml.safe_load(file)
        prior["sensors"]["gone"] = prior["sensors"]["lidar"]
        held = prior["sensors"]["lidar"]
        held["sigma"]["translation"] = [0.003, 0.004, 0.005]
        earlier = self.write("prior.yaml", yaml.safe_dump(prior))
        done = self.calibrate(DRIVE[1], DRIVE[0], "--prior", earlier, "--add", "cam_left")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("reused", done.stderr, "a prior makes other inputs of the kept stages")
        self.assertIn("gone: the prior has it, the rig file has not", done.stderr)
        with open(self.path("out/calibration.yaml")) as file:
            sensors = yaml.safe_load(file)["sensors"]
        self.assertEqual([sensors[name]["verdict"] for name in ["lidar", "cam_left"]], ["held", "trusted"])
        for key in ["translation", "rotation"]:
            for a, b in zip(sensors["lidar"]["T_imu_sensor"][key], held["T_imu_sensor"][key]):
                self.assertAlmostEqual(a, b, delta=1e-8)
        self.assertAlmostEqual(sensors["lidar"]["time_offset"], held["time_offset"], delta=1e-9)
        for camera, lidar in zip(sensors["cam_left"]["sigma"]["translation"], held["sigma"]["translation"]):
            self.assertGreater(camera, lidar)
            self.assertLess(camera, 1.5 * lidar)
        self.expect_end(self.calibrate(DRIVE[1], DRIVE[0], "--prior", earlier, "--add", "cam"), 1,
                        "prior.yaml: --add cam: the rig file has no such sensor")

    def test_a_camera_that_cannot_be_read_is_left_out(self):
        if not DRIVE:
            self.skipTest("no drive given")
        with open(DRIVE[1]) as file:
            topic = yaml.safe_load(file)["cameras"]["cam_left"]["topic"]
        with rosbag.Bag(DRIVE[0]) as bag, rosbag.Bag(self.path("a.bag"), "w") as copy:
            for name, message, time_recorded in bag.read_messages():
                if name == topic:
                    message.encoding = "nv21"
                copy.write(name, message, time_recorded)
        done = self.calibrate(DRIVE[1], self.path("a.bag"))
        self.assertEqual(done.returncode, 4, done.stderr)
        last = done.stderr.splitlines()[-3]
        for part in ["PARTIAL: 1 sensor, worst sigma ", "Rejected: cam_left: topic " + topic, "'nv21'"]:
            self.assertIn(part, last)
        with open(self.path("out/calibration.yaml")) as file:
            sensors = yaml.safe_load(file)["sensors"]
        self.assertEqual({name: sensor["verdict"] for name, sensor in sensors.items()},
                         {"lidar": "trusted", "cam_left": "rejected"})

    def moved_camera(self, calibration):
        """A calibration that has the camera 1 cm from where it is: the camera has moved since."""
        with open(calibration) as file:
            moved = yaml.safe_load(file)
        lidar, camera = moved["sensors"]["lidar"], moved["sensors"]["cam_left"]
        camera["T_imu_sensor"]["translation"][1] += 0.01
        x, y, z, w = lidar["T_imu_sensor"]["rotation"]
        row = [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)]  # 2nd of R_imu_lidar: y in its axes
        pair = moved["pairs"]["lidar/cam_left"]["T_a_b"]
        pair["translation"] = [old + 0.01 * by for old, by in zip(pair["translation"], row)]
        return self.write("moved.yaml", yaml.safe_dump(moved))

    def rig_with_intrinsics(self, calibration):
        """The drive's rig file with the camera's intrinsics as calibrated."""
        with open(calibration) as file:
            params = yaml.safe_load(file)["sensors"]["cam_left"]["intrinsics"]["params"]
        with open(DRIVE[1]) as file:
            rig = yaml.safe_load(file)
        rig["cameras"]["cam_left"]["intrinsics"] = params
        return self.write("rig_with_intrinsics.yaml", yaml.safe_dump(rig))

    def test_verify_names_what_moved(self):
        if not DRIVE:
            self.skipTest("no drive given")
        self.take_finished()
        found, table = self.path("out/calibration.yaml"), self.path("table.csv")
        same = self.run_program("verify", "--calibration", found, "--bag", DRIVE[0])
        self.assertEqual(same.returncode, 0, same.stdout + same.stderr)
        self.assertIn("AGREES: worst ", same.stdout.splitlines()[-1])
        moved = self.run_program("verify", "--calibration", self.moved_camera(found), "--bag", DRIVE[0],
                                 "--rig", DRIVE[1], "--output", table)
        self.assertEqual(moved.returncode, 2, moved.stdout + moved.stderr)
        last = moved.stdout.splitlines()[-1]
        self.assertIn("MOVED: cam_left by ", last)
        self.assertNotIn("lidar", last)
        self.assertNotIn("imu", last)
        with open(table) as file:
            moved = {row["sensor"]: row["moved"] for row in csv.DictReader(file)}
        self.assertEqual(moved, {"lidar": "0", "cam_left": "1"})
        self.expect_error(self.run_program("verify", "--calibration", DRIVE[1], "--bag", DRIVE[0]), "verify", "format")
        self.expect_error(self.run_program("verify", "--bag", DRIVE[0]), "verify", "--urdf")
        self.run_program("export", "--calibration", self.path("moved.yaml"), "--format", "urdf", "--output", self.path("r.urdf"))
        model = self.run_program("verify", "--urdf", self.path("r.urdf"), "--bag", DRIVE[0], "--rig", self.rig_with_intrinsics(found))
        self.assertEqual(model.returncode, 2, model.stdout + model.stderr)
        self.assertIn("MOVED: cam_left by ", model.stdout.splitlines()[-1])
        self.assertIn("poses of " + self.path("r.urdf") + " are taken as exact", model.stderr)

    def test_killed_run_goes_on_to_the_same_bytes(self):
        if not DRIVE:
            self.skipTest("no drive given")
        process = self.begin()
        self.lines_until(process, lambda line: "round 2" in line)
        process.kill()
        process.communicate(timeout=60)
        self.expect_nothing_but_the_log()
        resumed = self.calibrate(DRIVE[1], DRIVE[0])
        self.assertEqual(resumed.returncode, 0, resumed.stderr)
        for stage in ["LiDAR odometry", "initialisation", "joint adjustment"]:
            self.assertIn(stage + ": reused from an earlier run", resumed.stderr)
        with open(self.path("out/calibration.yaml")) as file:
            resumed = file.read()
        shutil.rmtree(self.output)
        self.assertNotIn("reused from", self.take_finished().stderr)
        with open(self.path("out/calibration.yaml")) as file:
            self.assertEqual(file.read(), resumed)

    def test_interruption(self):
        if not DRIVE:
            self.skipTest("no drive given")
        process = self.begin("--fresh")
        # Interrupted once it has begun to calibrate: well after loading.
        self.lines_until(process, lambda line: line.startswith("[") and not line.startswith("[loading]"))
        process.send_signal(signal.SIGINT)
        _, rest = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 130, rest)
        self.assertIn("INTERRUPTED: ", rest.splitlines()[-3])
        self.expect_nothing_but_the_log()


if __name__ == "__main__":
    PROGRAMS, DRIVE = sys.argv[1], sys.argv[2:4]
    unittest.main(argv=sys.argv[:1])
