"""The program under test: pushes the crate until it is fast enough to slide onto the mark by itself, then stops.

It knows where the mark is and what friction it believes in, and sees its own position only. How far the crate slides is
speed^2 / (2 friction gravity), so that is how it chooses its speed. The same program runs in every physics: as a controller of the
tool's own scene (this file, run as a program), and called by `simulate.py` in the others.
"""

import math

GRAVITY_M_S2 = 9.81


class Pusher:
    """Velocities for the plate, tick by tick."""

    def __init__(self, settings):
        self.release_m = settings["release_m"]
        slide_m = settings["mark_m"] - self.release_m - settings["crate_half_m"]
        self.speed_m_s = math.sqrt(2 * settings["believed_friction"] * GRAVITY_M_S2 * slide_m)
        self.acceleration_m_s2 = settings["acceleration_m_s2"]
        self.period_secs = settings["period_secs"]
        self.wanted_m_s = 0.0
        self.released = False

    def velocity(self, position_m):
        """The velocity of the plate (m/s) until the next tick."""
        self.released = self.released or position_m >= self.release_m
        faster = self.wanted_m_s + self.acceleration_m_s2 * self.period_secs
        self.wanted_m_s = 0.0 if self.released else min(faster, self.speed_m_s)
        return self.wanted_m_s


def main():
    """Joins it to the tool's own scene."""
    from corroborate_controller import Bool, Controller, Inputs, Outputs, Setup, run

    class Program(Controller):
        name, version = "pusher", "1"
        reports = {"released": Bool()}

        def set_up(self, setup: Setup) -> None:
            self.pusher = Pusher({**setup.settings, "period_secs": setup.period_secs})
            self.position_m = 0.0

        def tick(self, inputs: Inputs) -> Outputs:
            self.position_m = inputs.number("encoder", "position", default=self.position_m)
            velocity = self.pusher.velocity(self.position_m)
            return Outputs().command("drive", velocity=velocity).report(released=self.pusher.released)

    run(Program())


if __name__ == "__main__":
    main()
