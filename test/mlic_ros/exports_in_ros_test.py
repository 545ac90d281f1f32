#!/usr/bin/python3
"""Exports, loaded by the ROS programs they are for: exports_in_ros_test.py LAUNCH_ENVIRONMENT PROGRAM_DIRECTORY.

LAUNCH_ENVIRONMENT is the build's env.sh. Every pair of frames that tf then has is compared with calibration.yaml. A
program that is not installed skips its test.
"""
import importlib.util
import itertools
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import unittest
import xmlrpc.client

import rospy
import yaml
from tf2_msgs.msg import TFMessage

ENVIRONMENT, PROGRAMS = sys.argv[1:3]
NEAR = 1e-9  # m, and of quaternions, pixels
CAMERA = "{model: plumb_bob, image_size: [640, 480], params: [500.25, 501.5, 320.125, 240.5, 0.1, -0.02, 1e-5, 4e-4, 0.003]}"
# Quaternions of small and large turns with all their digits.
CALIBRATION = f"""format: mlic_calibration/1
verdict: trusted
imu: {{frame_id: imu_link}}
sensors:
  front:
    type: lidar
    frame_id: front_lidar
    T_imu_sensor: {{translation: [1.234567891234, -0.000123456789, 0.5], rotation: [0.5, -0.5, 0.5, 0.5]}}
    time_offset: 0.01
  rear:
    type: lidar
    frame_id: rear_lidar
    T_imu_sensor: {{translation: [-1.1, 0.7654321987654, 0.25], rotation: [0.1, 0.2, 0.3, 0.9273618495495703]}}
    time_offset: -0.002
  left:
    type: camera
    frame_id: left_optical
    T_imu_sensor: {{translation: [0.3333333333333, 0.2, -0.1], rotation: [-0.6, 0.0, 0.0012345678901, 0.7999990474138937]}}
    time_offset: 0.02
    intrinsics: {CAMERA}
"""
ROBOT = """<robot name="car">
  <link name="base_link"/>
  <link name="imu_link"/>
  <joint name="imu_joint" type="fixed"><parent link="base_link"/><child link="imu_link"/><origin xyz="1 2 3" rpy="0.1 0.2 0.3"/></joint>
  <link name="front_lidar"/>
  <joint name="front_joint" type="fixed"><parent link="base_link"/><child link="front_lidar"/><origin xyz="9 9 9"/></joint>
</robot>
"""


def multiply(p, q):
    (a, b, c, d), (x, y, z, w) = p, q
    return (d * x + a * w + b * z - c * y, d * y - a * z + b * w + c * x, d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z)


def rotate(q, v):
    conjugate = (-q[0], -q[1], -q[2], q[3])
    return multiply(multiply(q, (*v, 0.0)), conjugate)[:3]


def compose(a, b):
    """T_x_y * T_y_z of poses (translation, rotation)."""
    return tuple(p + q for p, q in zip(a[0], rotate(a[1], b[0]))), multiply(a[1], b[1])


def inverse(pose):
    conjugate = (-pose[1][0], -pose[1][1], -pose[1][2], pose[1][3])
    return tuple(-x for x in rotate(conjugate, pose[0])), conjugate


def installed(package, program):
    found = subprocess.run([ENVIRONMENT, "rospack", "find", package], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    return found.returncode == 0 and any(os.path.exists(os.path.join(folder, package, program))
                                         for folder in ("/usr/lib", "/opt/ros/noetic/lib"))


class Exports(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = folder.name
        with socket.socket() as one:
            one.bind(("", 0))
            port = one.getsockname()[1]
        os.environ.update(ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOME=cls.folder)
        core = subprocess.Popen([ENVIRONMENT, "roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
        cls.addClassCleanup(core.wait)
        cls.addClassCleanup(core.send_signal, signal.SIGINT)
        master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
        while core.poll() is None:
            try:
                master.getPid("/exports")
                break
            except OSError:
                threading.Event().wait(0.1)
        rospy.init_node("exports", disable_signals=True)
        cls.calibration = os.path.join(cls.folder, "calibration.yaml")
        with open(cls.calibration, "w") as file:
            file.write(CALIBRATION)
        sensors = yaml.safe_load(CALIBRATION)["sensors"].values()
        cls.poses = {"imu_link": ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))}
        for sensor in sensors:
            pose = sensor["T_imu_sensor"]
            cls.poses[sensor["frame_id"]] = (tuple(pose["translation"]), tuple(pose["rotation"]))

    def export(self, kind, name, *more):
        path = os.path.join(self.folder, name)
        done = subprocess.run([os.path.join(PROGRAMS, "export"), "--calibration", self.calibration, "--format", kind,
                               "--output", path, *more], stderr=subprocess.PIPE, universal_newlines=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return path

    def frames(self, topic, *command, root="imu_link"):
        """Poses of all frames but the root in their parents, (parent, pose) by frame, while the command runs."""
        frames, complete = {}, threading.Event()

        def receive(message):
            for transform in message.transforms:
                t, q = transform.transform.translation, transform.transform.rotation
                frames[transform.child_frame_id] = (transform.header.frame_id, ((t.x, t.y, t.z), (q.x, q.y, q.z, q.w)))
            if set(self.poses) - {root} <= set(frames):
                complete.set()

        watch = rospy.Subscriber(topic, TFMessage, receive)
        process = subprocess.Popen([ENVIRONMENT, *command], stdout=subprocess.DEVNULL)
        try:
            self.assertTrue(complete.wait(60.0), f"{command}: only {sorted(frames)}")
        finally:
            watch.unregister()
            process.send_signal(signal.SIGINT)
            process.wait()
        return frames

    def expect_every_pair(self, frames):
        """What tf2 would look up between two frames is their pose in calibration.yaml."""
        def to_root(frame):
            pose = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
            while frame in frames:
                frame, step = frames[frame]
                pose = compose(step, pose)
            return frame, pose

        self.assertEqual(len({to_root(frame)[0] for frame in self.poses}), 1, "one tree")
        pairs = list(itertools.permutations(self.poses, 2))
        self.assertEqual(len(pairs), 12)
        for a, b in pairs:
            found = compose(inverse(to_root(a)[1]), to_root(b)[1])
            expected = compose(inverse(self.poses[a]), self.poses[b])
            for x, y in zip(found[0], expected[0]):
                self.assertAlmostEqual(x, y, delta=NEAR, msg=f"{a} {b}")
            sign = 1.0 if sum(x * y for x, y in zip(found[1], expected[1])) > 0.0 else -1.0
            for x, y in zip(found[1], expected[1]):
                self.assertAlmostEqual(sign * x, y, delta=NEAR, msg=f"{a} {b}")

    def test_tf2_launch(self):
        launch = self.export("tf2", "tf2.launch")
        self.expect_every_pair(self.frames("/tf_static", "roslaunch", launch))

    def test_tf2_launch_about_a_sensor(self):
        launch = self.export("tf2", "about_rear.launch", "--parent", "rear_lidar")
        frames = self.frames("/tf_static", "roslaunch", launch, root="rear_lidar")
        self.assertEqual({parent for parent, _ in frames.values()}, {"rear_lidar"})
        self.expect_every_pair(frames)

    @unittest.skipUnless(installed("tf", "static_transform_publisher"), "tf is not installed")
    def test_tf_launch(self):
        self.expect_every_pair(self.frames("/tf", "roslaunch", self.export("tf", "tf.launch")))

    def publish(self, model, root="imu_link"):
        with open(model) as file:
            rospy.set_param("robot_description", file.read())
        return self.frames("/tf_static", "rosrun", "robot_state_publisher", "robot_state_publisher", root=root)

    @unittest.skipUnless(installed("robot_state_publisher", "robot_state_publisher"), "no robot_state_publisher")
    def test_urdf_in_robot_state_publisher(self):
        self.expect_every_pair(self.publish(self.export("urdf", "sensors.urdf")))

    @unittest.skipUnless(installed("robot_state_publisher", "robot_state_publisher"), "no robot_state_publisher")
    def test_merged_urdf_in_robot_state_publisher(self):
        robot = os.path.join(self.folder, "robot.urdf")
        with open(robot, "w") as file:
            file.write(ROBOT)
        frames = self.publish(self.export("urdf", "merged.urdf", "--urdf", robot), root="base_link")
        self.assertEqual(frames["imu_link"][0], "base_link")
        self.assertEqual(frames["front_lidar"][0], "base_link", "as the model has it")
        self.expect_every_pair(frames)

    @unittest.skipUnless(importlib.util.find_spec("camera_calibration_parsers"), "no camera_calibration_parsers")
    def test_camera_info(self):
        from camera_calibration_parsers import readCalibration
        name, info = readCalibration(os.path.join(self.export("camera_info", "camera_info"), "left.yaml"))
        self.assertEqual(name, "left")
        self.assertEqual((info.width, info.height, info.distortion_model), (640, 480, "plumb_bob"))
        fx, fy, cx, cy, *distortion = map(float, re.search(r"params: \[(.*?)\]", CAMERA).group(1).split(","))
        for found, expected in [(info.K, [fx, 0, cx, 0, fy, cy, 0, 0, 1]), (info.D, distortion),
                                (info.R, [1, 0, 0, 0, 1, 0, 0, 0, 1])]:
            self.assertEqual(len(found), len(expected))
            for x, y in zip(found, expected):
                self.assertAlmostEqual(x, y, delta=NEAR)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2, warnings="ignore")  # of sockets that rospy leaves open
