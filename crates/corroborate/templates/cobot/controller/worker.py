"""The program under test: moves parts from one side of the table to the other, slowly near people.

Replace it by your own: what a program gets and gives is in corroborate_controller/controller.py beside it.
"""

from corroborate_controller import Controller, Enumeration, Inputs, Number, Outputs, Setup, run

JOINTS = ("turn", "lift", "elbow")
# The poses of a cycle: above the part, at the part, up again; above its place, at its place, up again (rad).
CYCLE = [(0.9, -0.3, 1.0), (0.9, 0.1, 0.9), (0.9, -0.3, 1.0), (-0.9, -0.3, 1.0), (-0.9, 0.1, 0.9), (-0.9, -0.3, 1.0)]


class Worker(Controller):
    """States: work, slow, stand, done."""

    name, version = "worker", "1"
    # What it tells of its inside: recorded as /controller/worker.state and .parts.
    reports = {"state": Enumeration("work", "slow", "stand", "done"), "parts": Number("1")}

    def set_up(self, setup: Setup) -> None:
        """A new episode; everything of an earlier one is forgotten."""
        self.settings = setup.settings
        self.period = setup.period_secs
        self.wanted = list(CYCLE[0])
        self.step = 0
        self.parts = 0
        self.distance = float("inf")

    def tick(self, inputs: Inputs) -> Outputs:
        """From what has arrived to what is commanded, twenty times a second."""
        seen = inputs.sensors.get("detector")
        if seen is not None:
            self.distance = seen.values["distance"][0] if seen.values["seen"][0] else float("inf")
        state = self.state()
        rate = {"work": self.settings["fast_rad_s"], "slow": self.settings["slow_rad_s"]}.get(state, 0.0)
        self.move(rate * self.period)
        outputs = Outputs(finished=state == "done")
        for joint, position in zip(JOINTS, self.wanted):
            outputs.command(joint, position=position)
        return outputs.report(state=state, parts=self.parts)

    def state(self) -> str:
        """What to do about the nearest person."""
        if self.parts >= 2:
            return "done"
        if self.distance < self.settings["stop_distance_m"]:
            return "stand"
        return "slow" if self.distance < self.settings["slow_distance_m"] else "work"

    def move(self, most: float) -> None:
        """Moves the commanded pose towards the next one, no joint by more than `most` rad."""
        if self.parts >= 2:
            return
        goal = CYCLE[self.step]
        self.wanted = [now + max(-most, min(most, to - now)) for now, to in zip(self.wanted, goal)]
        if all(abs(now - to) < 1e-9 for now, to in zip(self.wanted, goal)):
            self.step = (self.step + 1) % len(CYCLE)
            self.parts += self.step == 0


if __name__ == "__main__":
    run(Worker())
