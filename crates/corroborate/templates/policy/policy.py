"""The policy under test: what was learned, behind `reset` and `act`.

This stand-in is linear, with three weights in weights.json. Replace it by your own: load a network in `__init__`, keep what
it remembers from step to step in `reset`, and compute the action in `act`.
"""

import json
import pathlib


class Policy:
    """From observations to actions."""

    def __init__(self):
        file = pathlib.Path(__file__).with_name("weights.json")
        self.weights = json.loads(file.read_text(encoding="utf-8"))

    def reset(self, seed):
        """A new episode begins; everything of an earlier one is forgotten. Whatever is random comes from `seed`."""
        del seed  # this policy draws nothing

    def act(self, observation):
        """The acceleration of the gripper in x and y, m/s², from where the part seems to be and how fast the gripper is."""
        most = self.weights["most_acceleration_m_s2"]
        wanted = (
            self.weights["towards_part"] * to_part - self.weights["against_speed"] * speed
            for to_part, speed in zip(observation["to_part_m"], observation["velocity_m_s"])
        )
        return [max(-most, min(most, acceleration)) for acceleration in wanted]
