"""Joins the cell's program to the tool's scene: sensors in, set points of the joints and the gripper out."""

import math
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from corroborate_controller import Controller, Enumeration, Inputs, Number, Outputs, Setup, run  # noqa: E402
from program import Program, joints  # noqa: E402


class Cell(Controller):
    """Twenty milliseconds a tick."""

    name, version = "cell", "1"
    reports = {"state": Enumeration(*Program.STATES), "parts": Number("1"), "lost": Number("1")}

    def set_up(self, setup: Setup) -> None:
        self.program = Program(setup.settings, setup.period_secs)

    def tick(self, inputs: Inputs) -> Outputs:
        program = self.program
        seen = inputs.number("scanner", "seen")
        distance = None if math.isnan(seen) else inputs.number("scanner", "distance") if seen else math.inf
        force = inputs.numbers("wrist", "force")
        holding = inputs.number("grip", "holding")
        program.tick(
            inputs.time_secs,
            distance,
            None if force is None else math.hypot(*force),
            None if math.isnan(holding) else bool(holding),
        )
        turn, lift, elbow, wrist = joints(*program.place)
        outputs = Outputs(finished=program.state == "done")
        outputs.command("joints", turn=turn, lift=lift, elbow=elbow, wrist=wrist)
        outputs.command("gripper", width=program.width_m, force=program.settings["grip_n"])
        return outputs.report(state=program.state, parts=program.parts, lost=program.lost)


if __name__ == "__main__":
    run(Cell())
