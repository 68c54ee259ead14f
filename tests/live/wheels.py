"""Plays the wheels of the corridor's carrier in the loop with its simulated rest, with a DDS that is not ours.

It says fifty times a second that the robot stands at --x metres, wherever it is, until the robot's program says that it
has arrived.
"""

import argparse
import time

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration

from corridor_messages import Layout, Numbers, String


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--domain", type=int, required=True)
    parser.add_argument("--x", type=float, required=True)
    options = parser.parse_args()
    participant = DomainParticipant(options.domain)
    quality = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100))
    wheels = DataWriter(participant, Topic(participant, "rt/wheels", Numbers), quality)
    states = DataReader(participant, Topic(participant, "rt/pilot/state", String), quality)
    seen = []
    while "arrived" not in seen:
        wheels.write(Numbers(Layout([], 0), [options.x, 0.0, 0.0, 0.0, 0.0]))
        for sample in states.take(N=1000):
            if sample.sample_info.valid_data and sample.data not in seen:
                seen.append(sample.data)
        time.sleep(0.02)
    print("saw " + " ".join(seen), flush=True)


if __name__ == "__main__":
    main()
