#!/usr/bin/python3
"""What inspect_bag --rig says of a simulated drive with faults put in: doctor_test.py PROGRAM_DIRECTORY DRIVE.bag RIG.yaml."""
import os
import subprocess
import sys
import tempfile
import unittest

import genpy
import rosbag

LIDAR, CAMERA, IMU = "/velodyne_points", "/cam_left/image_raw", "/imu/data"


class Doctor(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def diagnose(self, bag, rig):
        return subprocess.run([os.path.join(PROGRAMS, "inspect_bag"), "--rig", rig, bag], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, timeout=600)

    def with_faults(self, change):
        """The drive with the messages that change(topic, message, seconds) returns; None drops one."""
        path = os.path.join(self.folder, "faulty.bag")
        with rosbag.Bag(DRIVE) as source, rosbag.Bag(path, "w") as copy:
            begin = source.get_start_time()
            for topic, raw, time in source.read_messages(topics=[LIDAR, CAMERA, IMU], raw=True):
                message = raw[4]()
                message.deserialize(raw[1])
                message = change(topic, message, time.to_sec() - begin)
                if message is not None:
                    copy.write(topic, message, time)
        return path

    def rig_with(self, old, new):
        path = os.path.join(self.folder, "rig.yaml")
        with open(RIG) as source, open(path, "w") as copy:
            text = source.read()
            self.assertIn(old, text)
            copy.write(text.replace(old, new))
        return path

    def expect(self, done, grade, sensor, *parts):
        """One line of that grade on that sensor holds all the parts."""
        lines = [line for line in done.stdout.splitlines() if line.startswith(f"{grade}  {sensor}: ")]
        self.assertTrue(any(all(part in line for part in parts) for line in lines), done.stdout)

    def test_sound_drive(self):
        done = self.diagnose(DRIVE, RIG)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertNotIn("\nFAIL  ", done.stdout)
        self.expect(done, "PASS", "lidar", "rotation to the IMU")
        self.expect(done, "PASS", "forecast", "translation")
        self.assertIn(" passed, ", done.stdout.splitlines()[-1])

    def test_clock_gap_frozen_axis_and_images(self):
        frozen = []

        def change(topic, message, seconds):
            if topic == LIDAR and 3.0 < seconds < 4.5:
                return None
            if topic == LIDAR and seconds > 8.0:
                message.header.stamp += genpy.Duration(0, 100000000)
            if topic == IMU and 5.0 < seconds < 7.0:
                message.angular_velocity.z = 0.125
            if topic == CAMERA and seconds > 8.0:
                frozen.append(message.data)
                message.data = frozen[0]
            return message

        done = self.diagnose(self.with_faults(change), RIG)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.expect(done, "WARN", "lidar", "gaps: 1, 1.", "at 2.9")
        self.expect(done, "WARN", "lidar", "clock jumps: 1, the largest +100", "at 8.0")
        self.expect(done, "WARN", "imu", "frozen axis: gyroscope z", "at 5.00 s")
        self.expect(done, "WARN", "cam_left", "frozen images")

    def test_units_darkness_and_a_missing_topic(self):
        def change(topic, message, _):
            if topic == IMU:
                message.linear_acceleration.x /= 9.80665
                message.linear_acceleration.y /= 9.80665
                message.linear_acceleration.z /= 9.80665
            if topic == CAMERA:
                message.data = bytes(len(message.data))
            return message

        done = self.diagnose(self.with_faults(change), self.rig_with(LIDAR, "/no_such_topic"))
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.expect(done, "FAIL", "imu", "looks like g")
        self.expect(done, "FAIL", "cam_left", "dark")
        self.expect(done, "FAIL", "lidar", "/no_such_topic is not in the bag")

    def test_broken_messages(self):
        count = [0]

        def change(topic, message, _):
            count[0] += 1
            if topic == LIDAR:
                message.point_step = 0
            if topic == CAMERA:
                message.data = message.data[:100]
            if topic == IMU and count[0] % 3 == 0:
                message.angular_velocity.x = float("nan")
            return message

        done = self.diagnose(self.with_faults(change), RIG)
        self.assertEqual(done.returncode, 2, done.stdout + done.stderr)
        self.expect(done, "FAIL", "imu", "NaN")
        self.expect(done, "FAIL", "lidar", "point times", "malformed")
        self.expect(done, "FAIL", "cam_left", "cannot be decoded")

    def test_rig_that_is_not_filled_in(self):
        done = self.diagnose(DRIVE, self.rig_with("fov_deg: 90", "fov_deg: ???"))
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(done.stderr.splitlines()), 1, done.stderr)
        self.assertIn("cameras.cam_left.fov_deg", done.stderr)


if __name__ == "__main__":
    PROGRAMS, DRIVE, RIG = sys.argv[1:4]
    unittest.main(argv=sys.argv[:1])
