"""Drives the corridor's carrier as a node of ROS 2 would, with a DDS that is not ours (Eclipse Cyclone DDS).

The program is the case study's own, `case-studies/corridor/controller/corridor.py`; here it hears a scan, its wheels and
a call on topics, and answers each /clock with one message on each of its own topics. Whoever starts it names the domain
in ROS_DOMAIN_ID and gives the settings as parameters of ROS 2.

--hang-at SECONDS   stops answering there, to see that somebody notices
--twice-at SECONDS  answers twice there
"""

import json
import math
import os
import signal
import sys
import time
from types import SimpleNamespace

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from corridor_messages import Bool, Clock, Header, LaserScan, Layout, Numbers, String, Twist, TwistStamped, Vector3

sys.path.insert(0, os.path.join(os.environ["CORRIDOR"], "controller"))
from corridor import Corridor  # noqa: E402
from corroborate_controller import Inputs, Measurement, Message  # noqa: E402


def parameters(arguments):
    """What stands behind `--ros-args`, as `-p NAME:=VALUE`."""
    behind = arguments[arguments.index("--ros-args") + 1 :]
    given = (text.split(":=", 1) for text in behind[1::2])
    return {name: json.loads(value) for name, value in given}


def option(name):
    """The simulated time at which something is to go wrong."""
    return float(sys.argv[sys.argv.index(name) + 1]) if name in sys.argv else math.inf


class Node:
    def __init__(self, settings):
        self.participant = DomainParticipant(int(os.environ["ROS_DOMAIN_ID"]))
        self.quality = Qos(Policy.Reliability.Reliable(duration(seconds=5)), Policy.History.KeepLast(100))
        self.clock = self.reader("clock", Clock)
        self.scan = self.reader("scan", LaserScan)
        self.wheels = self.reader("wheels", Numbers)
        self.go = self.reader("go", Bool)
        self.drive = self.writer("cmd_vel", TwistStamped)
        self.state = self.writer("pilot/state", String)
        self.ahead = self.writer("pilot/ahead", Numbers)
        self.arrived = self.writer("pilot/arrived", Bool)
        self.corridor = Corridor()
        lidar = SimpleNamespace(
            fields={"ranges": SimpleNamespace(length=settings["rays"])},
            facts={
                "first_angle_rad": settings["first_angle_rad"],
                "angle_step_rad": settings["angle_step_rad"],
                "longest_m": settings["longest_m"],
            },
        )
        self.corridor.set_up(SimpleNamespace(sensors={"lidar": lidar}, settings=settings))
        self.wanted = {}

    def reader(self, name, kind):
        return DataReader(self.participant, Topic(self.participant, "rt/" + name, kind), self.quality)

    def writer(self, name, kind):
        return DataWriter(self.participant, Topic(self.participant, "rt/" + name, kind), self.quality)

    @staticmethod
    def take(reader):
        return [sample for sample in reader.take(N=1000) if sample.sample_info.valid_data]

    def inputs(self, now):
        """All that was told before the clock was."""
        sensors, messages = {}, []
        for scan in self.take(self.scan):
            # No return is infinite, as REP 117 has it.
            ranges = [math.nan if math.isinf(r) else r for r in scan.ranges]
            sensors["lidar"] = Measurement(now, {"ranges": ranges})
        for wheels in self.take(self.wheels):
            x, y, yaw, speed, turn_rate = wheels.data
            values = {"x": [x], "y": [y], "yaw": [yaw], "speed": [speed], "turn_rate": [turn_rate]}
            sensors["odometry"] = Measurement(now, values)
        for call in self.take(self.go):
            messages += [Message("go", now)] if call.data else []
        return Inputs(now, sensors, messages)

    def tick(self, clock):
        now = clock.sec + clock.nanosec / 1e9
        if now >= option("--hang-at"):
            time.sleep(3600)
        outputs = self.corridor.tick(self.inputs(now))
        self.wanted.update(outputs.commands.get("drive", {}))
        zero = Vector3(0.0, 0.0, 0.0)
        twist = Twist(Vector3(self.wanted["speed"], 0.0, 0.0), Vector3(0.0, 0.0, self.wanted["turn_rate"]))
        self.drive.write(TwistStamped(Header(clock, ""), twist))
        self.state.write(String(outputs.reports["state"]))
        clear = 1.0 if outputs.reports["clear"] else 0.0
        finished = 1.0 if outputs.finished else 0.0
        self.ahead.write(Numbers(Layout([], 0), [outputs.reports["ahead"], clear, finished]))
        for _ in range(2 if now >= option("--twice-at") else 1):
            self.arrived.write(Bool("arrived" in outputs.messages))

    def spin(self):
        while True:
            for clock in self.take(self.clock):
                self.tick(clock.clock)
            time.sleep(0.0002)


def main():
    signal.signal(signal.SIGINT, lambda *_: sys.exit(0))
    print("ready", flush=True)
    Node(parameters(sys.argv)).spin()


if __name__ == "__main__":
    main()
