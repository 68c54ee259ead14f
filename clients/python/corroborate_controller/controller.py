"""What passes between a controller and the bench."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, Dict, List, Mapping, Optional, Sequence, Union

from .reports import Report

Value = Union[float, bool, str]


@dataclass(frozen=True)
class PortField:
    """One value of a sensor or an actuator: its unit and how many numbers it has."""

    unit: str
    length: int


@dataclass(frozen=True)
class Port:
    """A sensor or an actuator: its kind, its values, and facts that stay the same."""

    kind: str
    fields: Mapping[str, PortField]
    facts: Mapping[str, float]

    @staticmethod
    def parse(form: Mapping[str, Any]) -> "Port":
        """From the protocol's form."""
        fields = {name: PortField(f["unit"], f["length"]) for name, f in form["fields"].items()}
        return Port(form["kind"], fields, dict(form["facts"]))


@dataclass(frozen=True)
class Setup:
    """What the bench offers for an episode."""

    seed: int
    period_secs: float
    sensors: Mapping[str, Port]
    actuators: Mapping[str, Port]
    settings: Mapping[str, Any]

    @staticmethod
    def parse(form: Mapping[str, Any]) -> "Setup":
        """From the protocol's form."""
        return Setup(
            seed=form["seed"],
            period_secs=form["period_secs"],
            sensors={name: Port.parse(port) for name, port in form["sensors"].items()},
            actuators={name: Port.parse(port) for name, port in form["actuators"].items()},
            settings=dict(form["settings"]),
        )


@dataclass(frozen=True)
class Measurement:
    """What a sensor measured, and when (it may have arrived later). NaN is a number that it could not measure."""

    time_secs: float
    values: Mapping[str, Sequence[float]]


@dataclass(frozen=True)
class Message:
    """A message and when it was sent."""

    name: str
    time_secs: float


@dataclass(frozen=True)
class Inputs:
    """What has arrived since the last tick. A sensor from which nothing came is absent."""

    time_secs: float
    sensors: Mapping[str, Measurement]
    messages: Sequence[Message]

    @staticmethod
    def parse(form: Mapping[str, Any]) -> "Inputs":
        """From the protocol's form; a missing number (`null`) becomes NaN."""
        sensors = {}
        for name, measurement in form["sensors"].items():
            values = {
                key: [math.nan if number is None else float(number) for number in numbers]
                for key, numbers in measurement["values"].items()
            }
            sensors[name] = Measurement(measurement["time_secs"], values)
        messages = [Message(m["name"], m["time_secs"]) for m in form["messages"]]
        return Inputs(form["time_secs"], sensors, messages)

    def numbers(self, sensor: str, name: str) -> Optional[Sequence[float]]:
        """The numbers of a sensor's field, or None if nothing came from it since the last tick."""
        measurement = self.sensors.get(sensor)
        return None if measurement is None else measurement.values[name]

    def number(self, sensor: str, name: str, default: float = math.nan) -> float:
        """The first of them, or `default` if nothing came."""
        numbers = self.numbers(sensor, name)
        return default if not numbers else numbers[0]

    def heard(self, message: str) -> bool:
        """Whether this message has come since the last tick."""
        return any(m.name == message for m in self.messages)


@dataclass
class Outputs:
    """What the controller wants. Commands and reports stay in force until replaced."""

    commands: Dict[str, Dict[str, float]] = field(default_factory=dict)
    messages: List[str] = field(default_factory=list)
    reports: Dict[str, Value] = field(default_factory=dict)
    finished: bool = False

    def command(self, actuator: str, **fields: float) -> "Outputs":
        """Commands an actuator, for example `command("drive", speed=0.5, turn_rate=0.0)`."""
        self.commands.setdefault(actuator, {}).update(fields)
        return self

    def send(self, message: str) -> "Outputs":
        """Sends a message."""
        self.messages.append(message)
        return self

    def report(self, **values: Value) -> "Outputs":
        """Reports values that the controller's `reports` declares."""
        self.reports.update(values)
        return self

    def form(self) -> Dict[str, Any]:
        """As the protocol has it."""
        for actuator, fields in self.commands.items():
            for name, value in fields.items():
                if not math.isfinite(value):
                    raise ValueError(f"the command {actuator}.{name} is {value}, which is no finite number")
        return {
            "type": "commands",
            "commands": self.commands,
            "messages": self.messages,
            "reports": self.reports,
            "finished": self.finished,
        }


class Controller:
    """A robot's code. Give it a name, a version and the two methods."""

    name: str = "controller"
    version: str = "1"
    sends: Sequence[str] = ()
    receives: Sequence[str] = ()
    reports: Mapping[str, Report] = {}

    def set_up(self, setup: Setup) -> None:
        """Begins an episode; everything of an earlier one is to be forgotten. Raise if something is missing."""
        raise NotImplementedError

    def tick(self, inputs: Inputs) -> Outputs:
        """From what has arrived to what is wanted."""
        raise NotImplementedError

    def end(self) -> None:
        """The episode is over."""
