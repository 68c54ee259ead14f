"""The program under test: takes a part and places it, step by step.

Replace it by your own: what a program gets and gives is in corroborate_controller/controller.py beside it.
"""

from corroborate_controller import Controller, Enumeration, Inputs, Outputs, Setup, run

OPEN, SHUT = 0.04, 0.0
# The steps in order; each lasts until the joints are where it wants them, or for its own time.
STATES = ("wait", "above", "down", "close", "lift", "carry", "set_down", "open", "up", "done")


class Placer(Controller):
    """States: wait for `go`, then the steps above, then done."""

    name, version = "placer", "1"
    receives = ("go",)
    sends = ("placed",)
    # What it tells of its inside: recorded as /controller/placer.state.
    reports = {"state": Enumeration(*STATES)}

    def set_up(self, setup: Setup) -> None:
        """A new episode; everything of an earlier one is forgotten."""
        settings = setup.settings
        part, tray, down = settings["part_m"], settings["tray_m"], settings["down_m"]
        # Where slide, lower and the fingers are wanted in each step.
        self.goals = {
            "wait": (part, 0.0, OPEN),
            "above": (part, 0.0, OPEN),
            "down": (part, down, OPEN),
            "close": (part, down, SHUT),
            "lift": (part, 0.0, SHUT),
            "carry": (tray, 0.0, SHUT),
            # The tray's plate is 5 mm higher than the table.
            "set_down": (tray, down - 0.006, SHUT),
            "open": (tray, down - 0.006, OPEN),
            "up": (tray, 0.0, OPEN),
            "done": (tray, 0.0, OPEN),
        }
        self.most = settings["speed_m_s"] * setup.period_secs
        self.state = "wait"
        self.since = 0.0
        self.wanted = [part, 0.0]

    def tick(self, inputs: Inputs) -> Outputs:
        """From what has arrived to what is commanded, twenty times a second."""
        if self.state == "wait":
            if inputs.heard("go"):
                self.enter("above", inputs.time_secs)
        elif self.state != "done" and self.arrived(inputs):
            self.enter(STATES[STATES.index(self.state) + 1], inputs.time_secs)
        slide, lower, finger = self.goals[self.state]
        self.wanted = [
            now + max(-self.most, min(self.most, to - now)) for now, to in zip(self.wanted, (slide, lower))
        ]
        outputs = Outputs(finished=self.state == "done")
        if self.state == "done":
            outputs.send("placed")
        for joint, position in zip(("slide", "lower", "left", "right"), (*self.wanted, finger, finger)):
            outputs.command(joint, position=position)
        return outputs.report(state=self.state)

    def enter(self, state: str, now: float) -> None:
        """Begins a step."""
        self.state, self.since = state, now

    def arrived(self, inputs: Inputs) -> bool:
        """Whether a step is over: fingers get 0.6 s; slide and palm have to be where they are wanted."""
        if self.state in ("close", "open"):
            return inputs.time_secs - self.since > 0.6
        positions = inputs.numbers("joints", "position")
        goal = self.goals[self.state][:2]
        return positions is not None and all(abs(now - to) < 0.004 for now, to in zip(positions, goal))


if __name__ == "__main__":
    run(Placer())
