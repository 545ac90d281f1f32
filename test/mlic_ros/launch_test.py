#!/usr/bin/python3
"""Calls calibrate.launch and evaluate.launch as a user does: launch_test.py LAUNCH_ENVIRONMENT DRIVE.bag RIG.yaml.

LAUNCH_ENVIRONMENT is the build's env.sh. The drive is calibrated once; most calls end before the work or find it done.
"""
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import unittest

ENVIRONMENT, DRIVE, RIG = sys.argv[1:4]


def free_port():
    with socket.socket() as one:
        one.bind(("", 0))
        return one.getsockname()[1]


class Launch(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = os.path.join(folder.name, "my drives")
        os.makedirs(os.path.join(cls.folder, "bin"))
        os.symlink(DRIVE, os.path.join(cls.folder, "the drive.bag"))
        shutil.copy(RIG, os.path.join(cls.folder, "rig.yaml"))

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def start(self, *arguments, file="calibrate.launch", display=None):
        environment = dict(os.environ, ROS_HOME=self.path("ros_home"), MLIC_STATUS_FILE=self.path("status"),
                           PATH=self.path("bin") + ":" + os.environ["PATH"], PWD=self.folder)
        environment.pop("DISPLAY", None)
        if display:
            environment["DISPLAY"] = display
        if os.path.exists(self.path("status")):
            os.remove(self.path("status"))
        return subprocess.Popen([ENVIRONMENT, "roslaunch", "-p", str(free_port()), "mlic", file, "rig:=rig.yaml", *arguments],
                                cwd=self.folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                universal_newlines=True)

    def launch(self, *arguments, **options):
        """All that was printed; the launch ends by itself."""
        process = self.start(*arguments, **options)
        try:
            return process.communicate(timeout=900)[0]
        finally:
            process.send_signal(signal.SIGINT)
            process.wait()

    def status(self):
        """Exit status and last lines of the calibration."""
        with open(self.path("status")) as file:
            lines = file.read().splitlines()
        return int(lines[0]), lines[1:]

    def fake_rviz(self, script):
        with open(self.path("bin", "rviz"), "w") as file:
            file.write("#!/bin/sh\n" + script + "\n")
        os.chmod(self.path("bin", "rviz"), 0o755)
        self.addCleanup(os.remove, self.path("bin", "rviz"))

    def expect_end(self, text, *lines, count=3):
        """The last lines stand on the terminal when the node ends, roslaunch says nothing alarming after that, and
        they are the last ones."""
        status, last = self.status()
        self.assertEqual(len(last), count, text)
        begin = text.find("\n".join(last))
        self.assertGreaterEqual(begin, 0, text)
        for line, part in zip(last, lines):
            self.assertIn(part, line)
        rest = text[begin + len("\n".join(last)):]
        for alarm in ["REQUIRED", "has died", "\x1b[31m", "warning", "escalating"]:
            self.assertNotIn(alarm, rest)
        self.assertEqual(text.splitlines()[-len(last):], last)
        return status

    def calibrated(self, *arguments, **options):
        """The drive's calibration; the first call does the work, the others find it done."""
        return self.launch("bag:=the drive.bag", "output:=my results", *arguments, **options)

    def test_relative_paths_with_blanks_and_no_display(self):
        text = self.calibrated()
        self.assertIn("RViz is not started: there is no display", text)
        status = self.expect_end(text, "TRUSTED: ", "report: " + self.path("my results", "report.html"),
                                 "use it: roslaunch '" + self.path("my results", "static_transforms.launch") + "'")
        self.assertEqual(status, 0)
        self.assertTrue(os.path.exists(self.path("my results", "calibration.yaml")))
        self.assertFalse(os.path.exists(self.path("ros_home", "my results")))

    def test_results_are_reused_and_their_end_is_the_same(self):
        self.calibrated("rviz:=false")
        first = self.status()
        text = self.calibrated("rviz:=false")
        self.assertIn("are reused", text)
        self.assertEqual(self.status(), first)
        self.expect_end(text, "TRUSTED: ")

    def test_rviz_that_dies_does_not_end_the_calibration(self):
        self.fake_rviz("exit 1")
        text = self.calibrated(display="localhost:99")
        self.assertEqual(self.expect_end(text, "TRUSTED: "), 0)

    def test_the_launch_stays_until_rviz_is_closed(self):
        self.fake_rviz(f"echo $$ > '{self.path('rviz_process')}'; exec sleep 1000")
        process = self.start("bag:=the drive.bag", "output:=my results", display="localhost:99")
        text = ""
        for line in process.stdout:
            text += line
            if line.startswith("use it:"):
                break
        self.assertIsNone(process.poll())
        self.assertIn("finished; the launch ends when RViz is closed", text)
        with open(self.path("rviz_process")) as file:
            os.kill(int(file.read()), signal.SIGTERM)
        text += process.communicate(timeout=60)[0]
        self.assertEqual(self.expect_end(text, "TRUSTED: "), 0)

    def test_evaluation_says_its_conclusion_last(self):
        self.calibrated("rviz:=false")
        calibration = "calibration:=my results/calibration.yaml"
        text = self.launch("bag:=the drive.bag", calibration, "truth:=my results/calibration.yaml", "output:=my evaluation",
                           file="evaluate.launch")
        self.assertEqual(self.expect_end(text, "errors agree with the claims", count=1), 0)
        for name in ["map_quality.csv", "coloured_map.pcd", "coloured_map.png"]:
            self.assertTrue(os.path.exists(self.path("my evaluation", name)), name)
        text = self.launch("bag:=none.bag", calibration, "output:=new", file="evaluate.launch")
        self.assertEqual(self.expect_end(text, "evaluate: ", count=1), 1)
        self.assertIn("none.bag", self.status()[1][0])
        self.assertFalse(os.path.exists(self.path("new")))

    def test_several_bags_and_one_that_is_missing(self):
        text = self.launch("bag:=the drive.bag none.bag", "output:=new", "rviz:=false")
        status = self.expect_end(text, "BAD INPUT: " + self.path("none.bag"), "log: none", "to do: ")
        self.assertEqual(status, 1)
        self.assertFalse(os.path.exists(self.path("new")))

    def test_options_are_those_of_calibrate(self):
        for argument, part in [("threads:=many", "threads"), ("intrinsics:=guess", "intrinsics"),
                               ("matcher:=learned", "matcher_weights:=DIR"), ("duration:=-1", "duration")]:
            text = self.launch("bag:=the drive.bag", "output:=new", "rviz:=false", argument)
            self.assertEqual(self.expect_end(text, "BAD INPUT: "), 1)
            self.assertIn(part, self.status()[1][0])

    def test_a_node_that_is_killed_has_a_last_word(self):
        process = self.start("bag:=the drive.bag", "output:=killed", "rviz:=false")
        owner = ""
        while not owner:
            self.assertIsNone(process.poll())
            if os.path.exists(self.path("killed", ".mlic_lock")):
                with open(self.path("killed", ".mlic_lock")) as file:
                    owner = file.read()
        os.kill(int(owner), signal.SIGKILL)
        text = process.communicate(timeout=60)[0]
        self.assertEqual(self.expect_end(text, "FAILED: calibrate_node was ended by signal 9", "log: ", "to do: "), 3)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
