"""Takes numbers that our publisher sends, with a DDS that is not ours, and says what it got and what was missing."""

import argparse
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class UInt32(IdlStruct, typename="std_msgs::msg::dds_::UInt32_"):
    data: uint32


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--last", type=int, required=True, help="the number after which to stop")
    options = parser.parse_args()
    participant = DomainParticipant(options.domain)
    topic = Topic(participant, "rt/bench/count", UInt32)
    quality = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepAll)
    reader = DataReader(participant, topic, quality)
    print("ready", flush=True)
    first, last, count, order = None, 0, 0, True
    while last < options.last:
        for sample in reader.take(N=1000):
            if sample.data == 0:
                continue
            first = first or sample.data
            order = order and sample.data > last
            last, count = sample.data, count + 1
        time.sleep(0.005)
    print(f"got {count} from {first} to {last} in {'order' if order else 'disorder'}", flush=True)


if __name__ == "__main__":
    main()
