#!/usr/bin/python3
"""Runs calibrate.launch, saves what is on the screen every 10 s, and presses the buttons of RViz's panel.

usage: press_panel.py BAG RIG FOLDER, by record_rviz.sh, which makes the screen. Buttons are pressed by xdotool with
their keys (Alt and the underlined letter); what they do is read from /mlic/status, files and the process.
"""
import contextlib
import os
import signal
import socket
import subprocess
import sys
import threading
import time
import xmlrpc.client

import rospy
import yaml
from mlic.msg import SensorStatus, Status

PERIOD = 10.0  # s between frames
PATIENCE = 60.0  # s that an effect may take: software rendering beside a calibration
LONGEST = 3600.0  # s that a calibration may take


def wait_for(what, condition, seconds=PATIENCE):
    """Its first true value: how long that takes is up to the machine."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.2)
    raise AssertionError(f"{what}: not within {seconds:.0f} s")


class Film:
    """Frames of the whole screen, NNNN[_WHAT].png by the seconds since the start."""

    def __init__(self, folder):
        self.folder, self.start, self.ended = folder, time.monotonic(), threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def seconds(self):
        return time.monotonic() - self.start

    def run(self):
        while not self.ended.wait(PERIOD - self.seconds() % PERIOD):
            self.take()

    def take(self, what=""):
        name = f"{round(self.seconds()):04d}" + (f"_{what}" if what else "") + ".png"
        subprocess.run(["import", "-window", "root", os.path.join(self.folder, name)], check=True)

    def take_drawn(self, what):
        """Once RViz had the time to draw what has just been published."""
        time.sleep(3.0)
        self.take(what)

    def end(self):
        self.ended.set()
        self.thread.join()


def window():
    found = subprocess.run(["xdotool", "search", "--onlyvisible", "--name", "RViz"], stdout=subprocess.PIPE,
                           universal_newlines=True)
    return found.stdout.split()[0] if found.stdout else None


def press(*keys):
    """In RViz' window; the name of a key as xdotool has it."""
    place = wait_for("RViz' window", window)
    subprocess.run(["xdotool", "windowfocus", "--sync", place, "key", "--delay", "300", *keys], check=True)


class Launch:
    """calibrate.launch in a session of its own, and what calibrates in it."""

    def __init__(self, bag, rig, output, log):
        self.output, self.status_file = output, os.environ["MLIC_STATUS_FILE"]
        with contextlib.suppress(FileNotFoundError):
            os.remove(self.status_file)
        self.process = subprocess.Popen(
            ["roslaunch", "mlic", "calibrate.launch", f"rig:={rig}", f"bag:={bag}", f"output:={output}"],
            stdout=log, stderr=subprocess.STDOUT, start_new_session=True)

    def cpu_seconds(self):
        with open(os.path.join(self.output, ".mlic_lock")) as file:
            worker = int(file.read())
        with open(f"/proc/{worker}/stat") as file:
            fields = file.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stands_still(self):
        """It takes next to no time of a core: the display's messages alone."""
        before = self.cpu_seconds()
        time.sleep(4.0)
        return self.cpu_seconds() - before < 0.4

    def exit_status(self):
        """Of the calibration; none before its end."""
        with contextlib.suppress(OSError, IndexError):
            with open(self.status_file) as file:
                return int(file.read().splitlines()[0])
        return None

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        self.process.wait(PATIENCE)


class Session:
    def __init__(self, bag, rig, folder):
        self.bag, self.rig = bag, rig
        self.output = os.path.join(folder, "calibration")
        self.log = open(os.path.join(folder, "launch.log"), "w")
        with socket.socket() as one:
            one.bind(("", 0))
            port = one.getsockname()[1]
        os.environ.update(ROS_MASTER_URI=f"http://localhost:{port}", ROS_HOME=os.path.join(folder, "ros"),
                          MLIC_STATUS_FILE=os.path.join(folder, "status"))
        self.master = subprocess.Popen(["roscore", "-p", str(port)], stdout=subprocess.DEVNULL)
        self.status = None
        self.film = Film(folder)
        self.listen()

    @contextlib.contextmanager
    def launch(self):
        launch = Launch(self.bag, self.rig, self.output, self.log)
        try:
            yield launch
        finally:
            launch.end()
            self.status = None

    def on_status(self, status):
        self.status = status

    def listen(self):
        master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])

        def answers():
            with contextlib.suppress(OSError):
                return master.getPid("/press_panel")

        wait_for("the ROS master", answers)
        rospy.init_node("press_panel", disable_signals=True)
        rospy.Subscriber("/mlic/status", Status, self.on_status)

    def end(self):
        self.film.end()
        self.master.send_signal(signal.SIGINT)
        self.master.wait(PATIENCE)

    def say(self, what):
        print(f"{self.film.seconds():6.0f} s  {what}", flush=True)

    def expect(self, what, condition, seconds=PATIENCE):
        wait_for(what, lambda: self.status is not None and condition(self.status), seconds)
        self.say(what)

    def pause_and_cancel(self):
        with self.launch() as launch:
            self.expect("the first stage is over", lambda s: s.stage_number > 1, LONGEST)
            press("alt+u")
            self.expect("Pause: the status says so", lambda s: s.paused)
            wait_for("Pause: the calibration stands still", launch.stands_still, 300.0)
            self.say("Pause: the calibration stands still")
            self.film.take("paused")
            press("alt+u")
            self.expect("Continue: no longer paused", lambda s: not s.paused)
            wait_for("Continue: the calibration works", lambda: not launch.stands_still())
            press("alt+c")
            self.expect("Cancel: interrupted", lambda s: s.state == Status.INTERRUPTED)
            wait_for("Cancel: exit status 130", lambda: launch.exit_status() == 130)
            assert not os.path.exists(os.path.join(self.output, "calibration.yaml")), "Cancel: there is a calibration"
            self.film.take_drawn("cancelled")
            self.close(launch)

    def close(self, launch):
        press("ctrl+q")
        self.film.take_drawn("closed")
        wait_for("RViz closed: the launch ends", lambda: launch.process.poll() is not None)
        self.say("RViz closed: the launch ends")

    def step_through_rounds(self):
        self.expect("three rounds", lambda s: s.rounds >= 3, LONGEST)
        press("alt+Left")
        self.expect("<: an earlier round", lambda s: s.shown_round > 0)
        shown = self.status.shown_round
        press("alt+Left")
        self.expect("<: the one before it", lambda s: s.shown_round == shown - 1)
        self.film.take_drawn("earlier_round")
        press("alt+Right")
        self.expect(">: the one after", lambda s: s.shown_round == shown)
        press("alt+l")
        self.expect("Latest: follows the calibration", lambda s: s.shown_round == 0)

    def export(self):
        press("alt+e")
        folder = os.path.join(self.output, "unfinished")
        names = ["calibration.yaml", "map.pcd", "trajectory.tum"]
        wait_for("Export now: its files", lambda: all(os.path.exists(os.path.join(folder, name)) for name in names))
        with open(os.path.join(folder, names[0])) as file:
            exported = yaml.safe_load(file)
        assert exported["verdict"] == "refused" and "unfinished" in exported["reasons"][0], exported["reasons"]
        found = {sensor.name for sensor in self.status.sensors if sensor.state != SensorStatus.WAITING}
        assert found <= set(exported["sensors"]), exported["sensors"].keys()
        self.say("Export now: its files, marked as unfinished")
        self.film.take_drawn("exported")

    def change_the_scene(self):
        for colouring in ["residual", "plane"]:
            press("alt+y", "Down")
            self.expect(f"colour by: {colouring}", lambda s, word=colouring: s.colour_by == word)
            self.film.take_drawn("by_" + colouring)
        press("alt+y", "Home")
        self.expect("colour by: sensor", lambda s: s.colour_by == "sensor")
        # From there back past Blink and < to the table: > and Latest are off.
        name = self.status.sensors[0].name
        press("alt+y", "shift+Tab", "shift+Tab", "shift+Tab", "ctrl+Home", "space")
        self.expect(f"the box of {name}: hidden", lambda s: s.hidden == [name])
        self.film.take_drawn("hidden")
        press("space")
        self.expect(f"the box of {name}: shown", lambda s: not s.hidden)
        press("Return")
        self.film.take_drawn("looked_at")
        press("alt+w")
        press("alt+b")
        self.expect("Blink: by turns", lambda s: s.blinks)
        for turn in ["blink_1", "blink_2", "blink_3"]:
            self.film.take(turn)
        press("alt+b")
        self.expect("Blink: no longer", lambda s: not s.blinks)

    def calibrate(self):
        with self.launch() as launch:
            self.step_through_rounds()
            self.export()
            self.change_the_scene()
            wait_for("the end", lambda: launch.exit_status() is not None, LONGEST)
            self.expect("a verdict", lambda s: s.state != Status.RUNNING)
            self.film.take_drawn("end")
            press("alt+y", "shift+Tab", "shift+Tab", "shift+Tab", "ctrl+Home", "Return")
            self.film.take_drawn("end_looked_at")
            status = launch.exit_status()
            self.close(launch)
        assert status in [0, 2, 4], f"exit status {status}"
        assert os.path.exists(os.path.join(self.output, "report.html")), "no report"
        self.say(f"exit status {status}")


def main(bag, rig, folder):
    session = Session(bag, rig, folder)
    try:
        session.pause_and_cancel()
        session.calibrate()
    except AssertionError as error:
        session.film.take("failed")
        print(f"press_panel.py: {error}", file=sys.stderr)
        return 1
    finally:
        session.end()
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
