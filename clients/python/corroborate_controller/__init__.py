"""Robot controllers for Corroborate's test bench, in Python.

A controller is a class with two methods. The bench tells it what there is, then asks it at a fixed rate; simulated time
stands still until it has answered. Nothing but Python's standard library is needed.

    from corroborate_controller import Controller, Inputs, Outputs, Setup, run

    class Careful(Controller):
        name, version = "careful", "1"

        def set_up(self, setup: Setup) -> None:
            self.cruise = setup.settings["cruise_speed_m_s"]

        def tick(self, inputs: Inputs) -> Outputs:
            ahead = inputs.number("range", "distance", default=0.0)
            return Outputs().command("drive", speed=self.cruise if ahead > 1.0 else 0.0)

    if __name__ == "__main__":
        run(Careful())

The same inputs and the same seed must give the same outputs: use `setup.seed` for random numbers, `inputs.time_secs` as
the clock, and forget everything in `set_up`. `print` goes to the error output, which the bench keeps.
"""

from .controller import Controller, Inputs, Measurement, Message, Outputs, Port, PortField, Setup
from .loop import PROTOCOL, serve, run
from .reports import Bool, Enumeration, Number

__all__ = [
    "PROTOCOL",
    "Bool",
    "Controller",
    "Enumeration",
    "Inputs",
    "Measurement",
    "Message",
    "Number",
    "Outputs",
    "Port",
    "PortField",
    "Setup",
    "run",
    "serve",
]
