#!/usr/bin/python3
"""Pauses and cancels a calibration that runs in calibrate_node by its services and checks how it ends."""
import os
import threading
import unittest

import rospy
from mlic.msg import Status
from std_srvs.srv import SetBool, Trigger


class CheckCancel(unittest.TestCase):
    def test_cancel_ends_the_run_and_says_so(self):
        works, ended = threading.Event(), threading.Event()
        last = []

        def on_status(status):
            last[:] = [status]
            if status.state != Status.RUNNING:
                ended.set()
            elif status.stage_number > 1:
                works.set()

        rospy.Subscriber("/mlic/status", Status, on_status)
        self.assertTrue(works.wait(200.0), "the calibration does not begin")
        rospy.wait_for_service("/mlic/cancel", 20.0)
        cancel = rospy.ServiceProxy("/mlic/cancel", Trigger)
        pause = rospy.ServiceProxy("/mlic/pause", SetBool)
        for paused in [True, False, True]:
            self.assertTrue(pause(paused).success)
            seen = threading.Event()
            watch = rospy.Subscriber("/mlic/status", Status,
                                     lambda status, wanted=paused, seen=seen: status.paused == wanted and seen.set())
            self.assertTrue(seen.wait(20.0), f"paused is to be {paused}")
            watch.unregister()
        self.assertTrue(cancel().success)
        self.assertTrue(ended.wait(20.0), "the calibration goes on")
        self.assertEqual(last[0].state, Status.INTERRUPTED, last[0].messages)
        self.assertIn("INTERRUPTED: ", last[0].messages[0])
        self.assertLess(last[0].run_progress, 1.0)
        path = rospy.get_param("~status_file")
        lines = []
        while len(lines) < 4 and not rospy.is_shutdown():
            rospy.sleep(0.1)
            lines = open(path).read().splitlines() if os.path.exists(path) else []
        self.assertEqual(lines[0], "130")
        self.assertFalse(os.path.exists(os.path.join(rospy.get_param("~output"), "calibration.yaml")))
        again = cancel()
        self.assertFalse(again.success)
        self.assertIn("ended", again.message)


if __name__ == "__main__":
    import rostest

    rospy.init_node("check_cancel")
    rostest.rosrun("mlic", "check_cancel", CheckCancel)
