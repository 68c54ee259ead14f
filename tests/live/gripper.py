"""Plays a part of a robot in the loop with a simulated rest, with a DDS that is not ours: a sensor in the hand.

It listens to what the simulated robot's code does (/robot/state) and says ten times a second whether it feels a pull
(/sensors/pressure_ok): always what it is told to, however the simulated person pulls. With --silent it says nothing.
"""

import argparse
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Bool(IdlStruct, typename="std_msgs::msg::dds_::Bool_"):
    data: bool


@dataclass
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--feels", choices=["yes", "no"], required=True)
    parser.add_argument("--silent", action="store_true")
    options = parser.parse_args()
    participant = DomainParticipant(options.domain)
    quality = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100))
    felt = DataWriter(participant, Topic(participant, "rt/sensors/pressure_ok", Bool), quality)
    states = DataReader(participant, Topic(participant, "rt/robot/state", String), quality)
    print("ready", flush=True)
    seen = []
    while not seen or seen[-1] not in ("done", "crashed"):
        if not options.silent:
            felt.write(Bool(options.feels == "yes"))
        for sample in states.take(N=1000):
            if sample.sample_info.valid_data and (not seen or seen[-1] != sample.data):
                seen.append(sample.data)
        time.sleep(0.1)
    print("saw " + " ".join(seen), flush=True)


if __name__ == "__main__":
    main()
