#!/usr/bin/python3
"""Waits for the end of a calibration that runs in calibrate_node and checks its topics, frames, files and status."""
import math
import os
import threading
import time
import unittest

import rospy
import yaml
from mlic.msg import Status
from mlic.srv import Choose
from nav_msgs.msg import Path
from sensor_msgs.msg import Image, PointCloud2
from std_srvs.srv import SetBool, Trigger
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

FILES = ["calibration.yaml", "static_transforms.launch", "sensors.urdf.xacro", "trajectory.tum", "map.pcd", "log.txt"]


class CheckCalibration(unittest.TestCase):
    """One run for all the checks: a calibration takes long."""

    @classmethod
    def setUpClass(cls):
        cls.statuses, cls.frames = [], {}
        cls.done = threading.Event()
        rospy.Subscriber("/mlic/status", Status, cls.on_status)
        rospy.Subscriber("/tf_static", TFMessage, cls.on_frames)
        cls.finished = cls.done.wait(800.0)
        cls.output = rospy.get_param("~output")
        with open(rospy.get_param("~rig")) as rig:
            cls.rig = yaml.safe_load(rig)
        path = os.path.join(cls.output, "calibration.yaml")
        cls.calibration = yaml.safe_load(open(path)) if os.path.exists(path) else {}

    @classmethod
    def on_status(cls, status):
        cls.statuses.append(status)
        if status.state != Status.RUNNING:
            cls.done.set()

    @classmethod
    def on_frames(cls, message):
        for transform in message.transforms:
            cls.frames[transform.child_frame_id] = transform

    def latched(self, topic, kind):
        return rospy.wait_for_message(topic, kind, 20.0)

    def expect(self, topic, kind, is_so):
        """A message that is so: what a service changes is published soon after its answer."""
        seen = threading.Event()
        watch = rospy.Subscriber(topic, kind, lambda message: is_so(message) and seen.set())
        self.assertTrue(seen.wait(20.0), topic)
        watch.unregister()

    def sensors(self):
        return [*self.rig["lidars"], *self.rig.get("cameras", {})]

    def test_status(self):
        self.assertTrue(self.finished, "no result within the time")
        last = self.statuses[-1]
        self.assertEqual(last.state, Status.TRUSTED, last.messages)
        self.assertGreater(len(last.costs), 0)
        self.assertGreater(len({status.stage for status in self.statuses}), 1)
        self.assertEqual(len(last.changes), len(last.costs))
        self.assertLess(last.changes[-1], 1.0)
        self.assertEqual(sorted(sensor.name for sensor in last.sensors), sorted(self.sensors()))
        for sensor in last.sensors:
            self.assertTrue(sensor.has_sigma)
            self.assertTrue(all(0.0 < sigma < 0.5 for sigma in sensor.sigma_translation), sensor)

    def test_progress_of_the_run(self):
        running = [status for status in self.statuses if status.state == Status.RUNNING and status.stage_count > 0]
        numbers = [status.stage_number for status in running]
        self.assertEqual(numbers, sorted(numbers))
        count = self.statuses[-1].stage_count
        self.assertEqual({status.stage_count for status in running}, {count})
        # The plan's stages are those that are told: the first may have passed before this looked.
        self.assertEqual(set(range(2, count + 1)) - set(numbers), set())
        done = [status.run_progress for status in running]
        self.assertEqual(done, sorted(done))
        self.assertGreater(len({status.seconds_left for status in running if status.seconds_left > 0.0}), 5)

    def test_rig_and_overlay(self):
        names = {marker.text for marker in self.latched("/mlic/rig", MarkerArray).markers if marker.text}
        self.assertEqual(names, {"IMU", *self.sensors()})
        self.assertEqual(self.latched("/mlic/overlay", MarkerArray).markers[0].text, "TRUSTED")

    def test_only_frames_below_the_prefix(self):
        for child, frame in self.frames.items():
            self.assertTrue(child.startswith("mlic/") and frame.header.frame_id.startswith("mlic/"), frame)
        self.assertEqual(self.statuses[-1].frame_prefix, "mlic/")

    def choose(self, service, word):
        rospy.wait_for_service(service, 20.0)
        return rospy.ServiceProxy(service, Choose)(word)

    def test_hidden_sensors_leave_the_scene_and_return(self):
        name = next(iter(self.rig["lidars"]))
        self.assertTrue(self.choose("/mlic/hide", name).success)
        self.expect("/mlic/voxel_map_points", PointCloud2, lambda cloud: cloud.width == 0)
        self.expect("/mlic/rig", MarkerArray, lambda rig: name not in {marker.text for marker in rig.markers})
        self.expect("/mlic/status", Status, lambda status: status.hidden == [name])
        self.assertTrue(self.choose("/mlic/show", name).success)
        self.expect("/mlic/voxel_map_points", PointCloud2, lambda cloud: cloud.width > 1000)
        self.expect("/mlic/rig", MarkerArray, lambda rig: name in {marker.text for marker in rig.markers})
        self.assertFalse(self.choose("/mlic/hide", "nobody").success)

    def test_earlier_rounds_are_shown(self):
        self.assertIn("is shown", self.choose("/mlic/round", "first").message)
        self.expect("/mlic/status", Status, lambda status: status.shown_round == 1)
        self.expect("/mlic/overlay", MarkerArray, lambda overlay: "round 1 of" in overlay.markers[0].text)
        self.assertTrue(self.choose("/mlic/round", "latest").success)
        self.expect("/mlic/status", Status, lambda status: status.shown_round == 0)
        self.expect("/mlic/overlay", MarkerArray, lambda overlay: overlay.markers[0].text == "TRUSTED")
        self.assertFalse(self.choose("/mlic/round", "third").success)

    def test_colours(self):
        self.assertTrue(self.choose("/mlic/colour_by", "residual").success)
        # Points, planes, landmarks and path.
        self.expect("/mlic/status", Status, lambda status: status.colour_by == "residual" and len(status.legend) == 8
                    and status.legend[1] == "on its plane" and "planes" in status.legend[3]
                    and "landmarks" in status.legend[4] and "path" in status.legend[6]
                    and len(status.legend_colours) == 8)
        self.assertTrue(self.choose("/mlic/colour_by", "sensor").success)
        self.assertFalse(self.choose("/mlic/colour_by", "weight").success)

    def test_guess_and_result_by_turns(self):
        blink = rospy.ServiceProxy("/mlic/blink", SetBool)
        self.assertTrue(blink(True).success)
        self.expect("/mlic/status", Status, lambda status: status.blinks)
        self.assertTrue(blink(False).success)
        self.expect("/mlic/status", Status, lambda status: not status.blinks)

    def test_a_result_is_not_exported_as_unfinished(self):
        answer = rospy.ServiceProxy("/mlic/export", Trigger)()
        self.assertFalse(answer.success)
        self.assertIn("ended", answer.message)
        self.assertFalse(rospy.ServiceProxy("/mlic/pause", SetBool)(True).success)

    def test_exit_status(self):
        path = rospy.get_param("~status_file")
        end = time.time() + 20.0
        while not (os.path.exists(path) and open(path).read().strip()) and time.time() < end:
            rospy.sleep(0.1)
        lines = open(path).read().splitlines()
        self.assertEqual((lines[0], len(lines)), ("0", 4))
        self.assertIn("TRUSTED: ", lines[1])

    def test_map(self):
        cloud = self.latched("/mlic/voxel_map_points", PointCloud2)
        self.assertEqual(cloud.header.frame_id, "mlic/map")
        self.assertGreater(cloud.width, 1000)
        names = {field.name for field in cloud.fields}
        self.assertLessEqual({"x", "y", "z", "rgb", "intensity", "lidar", "plane"}, names)
        markers = self.latched("/mlic/voxel_map", MarkerArray).markers
        self.assertGreater(len(markers[0].points), 6 * 10)
        self.assertEqual(len(markers[0].points), len(markers[0].colors))

    def test_cameras(self):
        landmarks = self.latched("/mlic/landmarks", PointCloud2)
        self.assertEqual(landmarks.header.frame_id, "mlic/map")
        self.assertGreater(landmarks.width, 50)
        self.assertLessEqual({"x", "y", "z", "rgb", "error", "observations"}, {field.name for field in landmarks.fields})
        outlines = self.latched("/mlic/cameras", MarkerArray).markers
        frames = {"mlic/" + self.calibration["sensors"][name]["frame_id"] for name in self.rig["cameras"]}
        self.assertEqual({outline.header.frame_id for outline in outlines}, frames)
        topics = [f"/mlic/{name}/{kind}" for name in self.rig["cameras"] for kind in ("tracks", "projection")]
        for topic in ["/mlic/tracks", "/mlic/projections", *topics]:
            image = self.latched(topic, Image)
            self.assertEqual((image.encoding, len(image.data)), ("bgr8", image.step * image.height))
            pixels = zip(image.data[0::3], image.data[1::3], image.data[2::3])
            coloured = sum(max(pixel) - min(pixel) > 60 for pixel in pixels)
            self.assertGreater(coloured, 500, "lines in colour on a gray photo: " + topic)
        # Beside the others one photo alone: six panels of each would be too small in RViz' window.
        self.assertEqual(len(self.rig["cameras"]), 1)
        all_cameras = self.latched("/mlic/projections", Image)
        width, height = self.calibration["sensors"][next(iter(self.rig["cameras"]))]["intrinsics"]["image_size"]
        self.assertEqual(all_cameras.height, all_cameras.width * height // width)
        for name in self.rig["cameras"]:
            image = self.latched(f"/mlic/{name}/projection", Image)
            width, height = self.calibration["sensors"][name]["intrinsics"]["image_size"]
            self.assertEqual((image.width, image.height), (2 * width, 3 * height), "two columns of three panels")
            for file in [f"camera_info/{name}.yaml", f"images/{name}_tracks.png", f"images/{name}_projection.png",
                         "images/keyframes.csv"]:
                self.assertGreater(os.path.getsize(os.path.join(self.output, file)), 0, file)

    def test_held_out_matches(self):
        for name in self.rig["cameras"]:
            held_out = self.calibration["sensors"][name]["held_out_matches"]
            self.assertGreater(held_out["count"], 20)
            self.assertLess(held_out["median"], 0.8, held_out)

    def test_trajectory(self):
        path = self.latched("/mlic/trajectory", Path)
        self.assertEqual(path.header.frame_id, "mlic/map")
        self.assertGreater(len(path.poses), 50)

    def test_frames_agree_with_the_file(self):
        imu = "mlic/" + self.calibration["imu"]["frame_id"]
        self.assertEqual(self.frames[imu].header.frame_id, "mlic/map")
        for sensor in self.calibration["sensors"].values():
            frame = self.frames["mlic/" + sensor["frame_id"]]
            self.assertEqual(frame.header.frame_id, imu)
            shown = frame.transform.translation
            for a, b in zip((shown.x, shown.y, shown.z), sensor["T_imu_sensor"]["translation"]):
                self.assertLess(math.fabs(a - b), 1e-5)

    def test_files(self):
        self.assertEqual(self.calibration["format"], "mlic_calibration/1")
        self.assertEqual(self.calibration["verdict"], "trusted")
        for name in FILES:
            path = os.path.join(self.output, name)
            self.assertTrue(os.path.exists(path) and os.path.getsize(path) > 0, name)
        self.assertFalse(os.path.exists(os.path.join(self.output, ".mlic_partial")))


if __name__ == "__main__":
    import rostest

    rospy.init_node("check_calibration")
    rostest.rosrun("mlic", "check_calibration", CheckCalibration)
