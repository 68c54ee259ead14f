"""Publishes joint states as a robot of ROS 2 would, with a DDS that is not ours (Eclipse Cyclone DDS).

Joint k of message n (from 1) stands at n + k / 1000. At the end it says how many messages it sent.
"""

import argparse
import os
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from cyclonedds.util import duration

JOINTS = 7


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]


def arguments():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--rate", type=float, required=True, help="messages a second")
    parser.add_argument("--seconds", type=float, required=True)
    parser.add_argument("--best-effort", action="store_true")
    return parser.parse_args()


def quality(best_effort):
    reliability = Policy.Reliability.BestEffort if best_effort else Policy.Reliability.Reliable(duration(seconds=1))
    return Qos(reliability, Policy.Durability.Volatile, Policy.History.KeepLast(1000))


def joint_state(number):
    now = time.time_ns()
    stamp = Time(now // 1_000_000_000, now % 1_000_000_000)
    names = [f"joint_{k}" for k in range(JOINTS)]
    positions = [number + k / 1000 for k in range(JOINTS)]
    return JointState(Header(stamp, "base"), names, positions, [0.0] * JOINTS, [])


def say_pid():
    """Tells whoever wants to kill this process its number."""
    if path := os.environ.get("LIVE_PID_FILE"):
        with open(path, "w") as file:
            file.write(str(os.getpid()))


def main():
    options = arguments()
    say_pid()
    participant = DomainParticipant(options.domain)
    topic = Topic(participant, "rt/joint_states", JointState)
    writer = DataWriter(participant, topic, quality(options.best_effort))
    print("ready", flush=True)
    # Discovery takes its time where datagrams are lost.
    while not writer.get_matched_subscriptions():
        time.sleep(0.01)
    count = round(options.rate * options.seconds)
    start = time.monotonic()
    for number in range(1, count + 1):
        writer.write(joint_state(number))
        wait = start + number / options.rate - time.monotonic()
        if wait > 0:
            time.sleep(wait)
    # What was lost on the way may still be asked for.
    if not options.best_effort:
        time.sleep(2)
    print(f"sent {count}", flush=True)


if __name__ == "__main__":
    main()
