"""Swings a pendulum up by its energy, and holds it upright by its angle: the classical two laws, and where they take turns."""

import math

import numpy

TORQUE_NM = 2.0
# The rod of the environment: 1 kg, 1 m, and the gravity that the policy believes in.
INERTIA_KG_M2 = 1.0 / 3.0
WEIGHT_NM = 10.0 * 0.5


class Swing:
    """Made for an environment, of which it needs nothing: it sees cosine, sine and angular velocity."""

    def __init__(self, env):
        pass

    def select_action(self, observation):
        """A torque."""
        cosine, sine, speed = (float(number) for number in observation)
        angle = math.atan2(sine, cosine)
        if cosine > 0.9:
            torque = -(12.0 * angle + 3.0 * speed)
        else:
            missing = WEIGHT_NM * (1.0 - cosine) - 0.5 * INERTIA_KG_M2 * speed * speed
            torque = math.copysign(TORQUE_NM, speed if speed else 1.0) * (1.0 if missing > 0 else -1.0)
        return numpy.array([max(-TORQUE_NM, min(TORQUE_NM, torque))], dtype=numpy.float32)
