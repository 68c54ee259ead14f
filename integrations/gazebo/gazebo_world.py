"""A world of Gazebo (gz-sim) over gz-transport in lock step: it stands still but for the steps that are asked for.

    with served("arm.sdf", seed=episode.seed) as transport:
        world = World(transport, "arm_world", step_secs=0.001)
        world.reset()
        for tick in range(500):
            world.command("/arm/joint_1/cmd_force", Double(data=0.3))
            world.step(10)
            position_m, orientation_xyzw = world.pose("arm")

Units are SI. Poses are as Gazebo publishes them: of a model in the frame of the world (z upwards), of a link in the frame of its model.

`control` answers when a request is queued, not when it is carried out, and poses are published at a rate of the wall clock
(60 Hz unless the world's SceneBroadcaster has another `<dynamic_pose_hertz>`). So a step is over when a pose is stamped with the
time that it ends at.
"""

from __future__ import annotations

import contextlib
import importlib
import os
import signal
import subprocess
import threading
import uuid
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Protocol, Tuple, Union

NS = 1_000_000_000
Pose = Tuple[Tuple[float, float, float], Tuple[float, float, float, float]]


class Transport(Protocol):
    """All that a `World` needs of gz-transport."""

    def message(self, name: str) -> Any:
        """The type of the message `gz.msgs.NAME`."""

    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> None:
        """Calls back for each message, in a thread of its own."""

    def publish(self, topic: str, message: Any) -> None:
        """Publishes a message."""

    def request(self, service: str, message: Any, reply: Any, limit_secs: float) -> Any:
        """What a service replies; None if it does not within the limit."""


class GzTransport:
    """The Python bindings that come with Gazebo: of Harmonic `gz.transport13` and `gz.msgs10`, of Ionic 14 and 11."""

    def __init__(self, transport: int = 13, messages: int = 10):
        self.messages = f"gz.msgs{messages}"
        try:
            self.node = importlib.import_module(f"gz.transport{transport}").Node()
            self.message("WorldControl")
        except ImportError as error:
            raise RuntimeError(
                f"the Python bindings gz.transport{transport} and {self.messages} of Gazebo cannot be imported ({error}); install "
                f"python3-gz-transport{transport} and python3-gz-msgs{messages}, or name the versions that are there"
            ) from error
        self.publishers: Dict[str, Any] = {}

    def message(self, name: str) -> Any:
        """The type of a message; the module is its name in lower case with underscores."""
        module = "".join(f"_{one.lower()}" if one.isupper() and place and name[place - 1] != "_" else one.lower()
                         for place, one in enumerate(name))
        return getattr(importlib.import_module(f"{self.messages}.{module}_pb2"), name)

    def subscribe(self, topic: str, kind: Any, callback: Callable[[Any], None]) -> None:
        """Calls back for each message."""
        if not self.node.subscribe(kind, topic, callback):
            raise RuntimeError(f"Gazebo's transport refused to subscribe to {topic}")

    def publish(self, topic: str, message: Any) -> None:
        """Publishes a message; the first one on a topic may be sent before a subscriber is connected."""
        if topic not in self.publishers:
            self.publishers[topic] = self.node.advertise(topic, type(message))
        self.publishers[topic].publish(message)

    def request(self, service: str, message: Any, reply: Any, limit_secs: float) -> Any:
        """What a service replies."""
        answered, told = self.node.request(service, message, type(message), reply, round(1000 * limit_secs))
        return told if answered else None


class World:
    """A world of a server that runs, under control. `step_secs` is the world's `<max_step_size>`."""

    def __init__(self, transport: Transport, name: str, step_secs: float, limit_secs: float = 10.0):
        if step_secs <= 0:
            raise ValueError(f"`step_secs` must be positive (got {step_secs:g})")
        self.transport, self.name, self.limit_secs = transport, name, limit_secs
        self.step_ns, self.time_ns = round(step_secs * NS), 0
        self.came = threading.Condition()
        self.seen_ns, self.poses = -1, {}
        transport.subscribe(f"/world/{name}/dynamic_pose/info", transport.message("Pose_V"), self._take)

    def _take(self, message: Any) -> None:
        found: Dict[str, List[Pose]] = {}
        for one in message.pose:
            place, turn = one.position, one.orientation
            found.setdefault(one.name, []).append(((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w)))
        with self.came:
            self.seen_ns, self.poses = message.header.stamp.sec * NS + message.header.stamp.nsec, found
            self.came.notify_all()

    @property
    def time_secs(self) -> float:
        """The simulated time."""
        return self.time_ns / NS

    def reset(self, seed: int = 0) -> None:
        """To the beginning, and pauses. gz-sim 8 ignores a seed here, with a warning: give it to the server (`served`)."""
        control = self.transport.message("WorldControl")(pause=True, seed=seed % 2**32)
        control.reset.all = True
        self._control(control)
        self.time_ns = 0
        self._wait()

    def step(self, count: int = 1) -> None:
        """So many time steps; over when the poses after them are there."""
        if count < 1:
            raise ValueError(f"a number of steps must be at least 1 (got {count})")
        self.time_ns += count * self.step_ns
        self._control(self.transport.message("WorldControl")(pause=True, multi_step=count))
        self._wait()

    def command(self, topic: str, message: Any) -> None:
        """A message to the world's plugins. It goes another way than the control of steps, so that it may act a step later."""
        self.transport.publish(topic, message)

    def pose(self, name: str) -> Pose:
        """Position (m) and orientation (quaternion x, y, z, w) of a model or link that is not static."""
        found = self.poses.get(name, [])
        if len(found) != 1:
            there = ", ".join(sorted(self.poses)) or "none"
            raise KeyError(f"{len(found) or 'no'} moving things are called `{name}`; there are {there}")
        return found[0]

    def _control(self, control: Any) -> None:
        service = f"/world/{self.name}/control"
        reply = self.transport.request(service, control, self.transport.message("Boolean"), self.limit_secs)
        if reply is None or not reply.data:
            how = "refused" if reply is not None else "did not answer"
            raise RuntimeError(f"{service} {how}: is a world called `{self.name}` running?")

    def _wait(self) -> None:
        with self.came:
            if not self.came.wait_for(lambda: self.seen_ns == self.time_ns, self.limit_secs):
                seen = "none have come: does it have a SceneBroadcaster?"
                if self.seen_ns >= 0:
                    seen = f"the last are of {self.seen_ns / NS:g} s"
                raise TimeoutError(
                    f"no poses of {self.time_secs:g} s came from world `{self.name}` within {self.limit_secs:g} s; {seen}. Is "
                    f"{self.step_ns / NS:g} s its max_step_size, and does no other program control it?"
                )


@contextlib.contextmanager
def served(world_file: Union[str, Path], seed: int, versions: Tuple[int, int] = (13, 10)) -> Iterator[GzTransport]:
    """A server of its own, paused and without a window, in a partition of its own, so that others on this machine do not meet it."""
    partition = f"corroborate-{uuid.uuid4().hex}"
    os.environ["GZ_PARTITION"] = partition
    words = ["gz", "sim", "-s", "--seed", str(seed % 2**31), str(world_file)]
    try:
        server = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=2)
    except FileNotFoundError as error:
        raise RuntimeError("`gz` was not found; install Gazebo") from error
    try:
        yield GzTransport(*versions)
    finally:
        server.send_signal(signal.SIGINT)
        try:
            server.wait(1.0)
        except subprocess.TimeoutExpired:
            server.kill()
            server.wait()
