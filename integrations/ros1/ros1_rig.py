"""ROS 1 nodes under test with a simulated world, in lock step with its clock; or in real time, as hardware is (`real_time`).

    from std_msgs.msg import Float64
    from ros1_rig import Answer, Ros1Rig, main

    class World:
        signals = {"/truth/base.x": "m"}     # columns of the recording, with units
        settings = ("base.x_m",)             # settings of the stimulus that it reads

        def reset(self, episode): ...        # -> {topic: message}, what the sensors show at the beginning
        def step(self, commands): ...        # {topic: last message} -> {topic: message} a tick later; None ends the episode
        def row(self): ...                   # values of the signals now

    main(lambda: Ros1Rig(World(), "robot.launch", {"/command": Answer(Float64)}, tick_secs=0.05, duration_secs=10.0))

A tick: `/clock` is set, the sensors are published, stamped with the clock, and the world waits, in real time, until each topic of
`answers` has had its number of messages; if `quiet_secs` is given, also until no message has come for that long. Then the
world steps. A program that dies or that does not answer within `limit_secs` fails the episode, with the reason.
Times are seconds; a recording's time is that of the episode, 0 at its beginning.
"""

from __future__ import annotations

import copy
import math
import os
import signal
import socket
import sys
import threading
import time
import xmlrpc.client
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Deque, Dict, List, Mapping, Optional, Sequence, Tuple

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "common"), str(HERE)]

import rosbag  # noqa: E402
import rosgraph  # noqa: E402
import rospy  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from std_msgs.msg import Bool, Float64, String  # noqa: E402

import corroborate_rig  # noqa: E402
from corroborate_rig import Cell, Episode, Recording  # noqa: E402
from ros1_stack import Command, Stack  # noqa: E402

Readings = Mapping[str, Any]

# Time 0 means "no clock yet" to ROS, so an episode begins at one second.
FIRST_CLOCK_NS = 1_000_000_000
NS = 1_000_000_000
LINGER_SECS = 0.1
NAME = "/corroborate_rig"


@dataclass(frozen=True)
class Answer:
    """A topic on which nodes answer: the type of its messages, and how many come in each tick; with 0 it is only listened to.
    A node has to publish it."""

    type: Any
    count: int = 1


class Kept:
    """What an episode leaves: a table in CSV with the world's signals, or a bag with all messages and each signal as a topic
    (`/truth/base.x` is `/truth/base/x`, in its field `data`). The extension of the file decides."""

    def __init__(self, signals: Mapping[str, str]):
        self.names = list(signals)
        self.table = Recording(signals)
        self.messages: List[Tuple[int, str, Any]] = []
        self.counts: Dict[str, int] = {}

    def message(self, time_ns: int, topic: str, message: Any, clock_began_ns: int) -> None:
        """A message at a time of the episode; its stamp and number become those of the episode, whatever ran before."""
        kept = copy.deepcopy(message)
        self.counts[topic] = self.counts.get(topic, 0) + 1
        if getattr(kept, "_has_header", False):
            kept.header.seq = self.counts[topic]
            if not kept.header.stamp.is_zero():
                kept.header.stamp = _ros_time(max(0, kept.header.stamp.to_nsec() - clock_began_ns) + FIRST_CLOCK_NS)
        self.messages.append((time_ns, topic, kept))

    def row(self, time_ns: int, cells: Sequence[Cell]) -> None:
        """The signals at a time of the episode."""
        self.table.row(time_ns / NS, *cells)
        for name, cell in zip(self.names, cells):
            if cell is not None:
                kind = Bool if type(cell).__name__ in ("bool", "bool_") else String if isinstance(cell, str) else Float64
                self.messages.append((time_ns, name.replace(".", "/"), kind(cell)))

    def text(self) -> str:
        """The table."""
        return self.table.text()

    def write(self, path: str) -> None:
        """Written whole, renamed last."""
        ending = Path(path).suffix
        if ending == ".csv":
            return self.table.write(path)
        if ending != ".bag":
            raise ValueError(f"this rig leaves `csv` or `bag`, not `{ending.lstrip('.')}`")
        part = f"{path}.part"
        with rosbag.Bag(part, "w") as bag:
            # A bag has no time 0 either.
            for time_ns, topic, message in self.messages:
                bag.write(topic, message, _ros_time(time_ns + FIRST_CLOCK_NS))
        os.replace(part, path)


def _ros_time(nanoseconds: int) -> Any:
    return rospy.Time(nanoseconds // NS, nanoseconds % NS)


class Inbox:
    """Messages of the nodes in the order in which they came, with the time of their coming (s, of a clock that only goes on)."""

    def __init__(self, answers: Mapping[str, Answer]):
        self.answers = answers
        self.came = threading.Condition()
        self.messages: List[Tuple[str, Any, float]] = []
        self.subscribers = {
            topic: rospy.Subscriber(topic, answer.type, self._take, topic, queue_size=None, tcp_nodelay=True)
            for topic, answer in answers.items()
        }

    def _take(self, message: Any, topic: str) -> None:
        with self.came:
            self.messages.append((topic, message, time.monotonic()))
            self.came.notify_all()

    def missing(self) -> List[str]:
        """Topics that have not yet had all answers of a tick."""
        had = [topic for topic, _, _ in self.messages]
        return [topic for topic, answer in self.answers.items() if had.count(topic) < answer.count]

    def taken(self) -> List[Tuple[str, Any, float]]:
        """Takes out what has come."""
        with self.came:
            found, self.messages = self.messages, []
        return found


class Latencies:
    """How long answers took, in seconds, topic by topic: an answer with a stamp belongs to the readings of that stamp, others to
    the oldest readings without an answer. So a lost answer makes what follows look slower, never faster."""

    def __init__(self, topics: Sequence[str]):
        self.waiting: Dict[str, Deque[Tuple[int, float]]] = {topic: deque() for topic in topics}
        self.worst: Dict[str, Optional[float]] = dict.fromkeys(topics)

    def published(self, stamp_ns: int, at_secs: float) -> None:
        """Readings were published."""
        for waiting in self.waiting.values():
            waiting.append((stamp_ns, at_secs))

    def answered(self, topic: str, message: Any, at_secs: float) -> None:
        """A message came."""
        waiting = self.waiting.get(topic)
        if not waiting:
            return
        header = getattr(message, "header", None)
        stamp = header.stamp.to_nsec() if header is not None else 0
        stamps = [known for known, _ in waiting]
        if stamp and stamp not in stamps:
            return
        # What was published before is passed over by an answer to what came later.
        for _ in range(stamps.index(stamp) if stamp else 0):
            waiting.popleft()
        self._seen(topic, at_secs - waiting.popleft()[1])

    def _seen(self, topic: str, secs: float) -> None:
        self.worst[topic] = max(secs, self.worst[topic] or 0.0)

    def row(self, now_secs: float) -> List[Optional[float]]:
        """The longest of each topic since the last row; readings without an answer count with their age, which is the least it can be."""
        for topic, waiting in self.waiting.items():
            if waiting:
                self._seen(topic, now_secs - waiting[0][1])
        found, self.worst = list(self.worst.values()), dict.fromkeys(self.worst)
        return found


class Ros1Rig:
    """Nodes (a launch file, or commands as lists of words) with a world. `run` plays an episode, `close` ends everything.

    `reset_service` keeps the nodes alive between episodes and calls this service (std_srvs/Empty) instead: the clock goes on, as
    it may not go back for a node that lives. `port` is the master's, a free one if left out. `package_path` goes before
    ROS_PACKAGE_PATH. `settle_secs` is what the clock gets to arrive before the readings do: they come by other connections.

    `real_time` has no clock of its own: ticks last as long as they are long, a command counts from the tick after its coming, and
    each answer's latency is a signal, `/latency/TOPIC.secs`. `master` names a master that runs elsewhere, with the robot's
    nodes; then nothing is started here and `nodes` is None.
    """

    def __init__(
        self, world: Any, nodes: Optional[Command], answers: Mapping[str, Any], tick_secs: float, duration_secs: float,
        quiet_secs: float = 0.0, limit_secs: float = 10.0, reset_service: Optional[str] = None, port: Optional[int] = None,
        package_path: Sequence[Any] = (), settle_secs: float = 0.001, real_time: bool = False, master: Optional[str] = None,
    ):
        self.world, self.nodes, self.master = world, nodes, master
        self.answers = {topic: one if isinstance(one, Answer) else Answer(one) for topic, one in answers.items()}
        if not 0 < tick_secs <= duration_secs:
            raise ValueError(
                f"`tick_secs` must be positive (got {tick_secs:g}), and `duration_secs` at least as long (got {duration_secs:g})"
            )
        self.tick_ns, self.ticks = round(tick_secs * NS), round(duration_secs / tick_secs)
        self.quiet_secs, self.limit_secs, self.settle_secs = quiet_secs, limit_secs, settle_secs
        self.reset_service, self.real_time = reset_service, real_time
        self._check()
        self.clock_ns = FIRST_CLOCK_NS - self.tick_ns
        self.publishers: Dict[str, rospy.Publisher] = {}
        self.waits_secs: List[float] = []  # How long ticks waited for their answers, for whoever measures.
        self.set_before: List[str] = []
        self.running = False
        self.stack = None if master else Stack(port, package_path=package_path)
        try:
            self._join(master or self.stack.uri)
        except BaseException:
            self.close()
            raise

    def _check(self) -> None:
        """What cannot work is said before anything is started."""
        if self.settle_secs < 0 or self.quiet_secs < 0 or self.limit_secs <= self.quiet_secs:
            raise ValueError("`settle_secs` and `quiet_secs` must not be negative, and `limit_secs` must be longer than `quiet_secs`")
        if not self.real_time and not self.quiet_secs and not any(answer.count for answer in self.answers.values()):
            raise ValueError("nothing says when a tick is over: declare `answers` that come in each tick, or `quiet_secs`")
        if self.master and (self.nodes is not None or not self.real_time):
            raise ValueError("with `master` the nodes run elsewhere: `real_time` must be true and `nodes` None")
        if not self.master and self.nodes is None:
            raise ValueError("`nodes` must be a launch file or commands, unless `master` says where they run")

    def _join(self, uri: str) -> None:
        """Becomes a node itself. That is possible once in a process, so a process has one rig."""
        os.environ["ROS_MASTER_URI"] = uri
        if self.stack:
            os.environ["ROS_HOSTNAME"] = "localhost"
            os.environ.pop("ROS_IP", None)
        if not rosgraph.is_master_online(uri):
            raise RuntimeError(f"no ROS master answers at {uri}")
        if not self.real_time:
            rosgraph.Master(NAME).setParam("/use_sim_time", False)
        rospy.init_node(NAME[1:], disable_signals=True)
        if self.stack:
            rosgraph.Master(NAME).setParam("/use_sim_time", not self.real_time)
        self.clock = None if self.real_time else rospy.Publisher("/clock", Clock, queue_size=0)
        self.inbox = Inbox(self.answers)

    # One episode.

    def run(self, episode: Episode) -> Kept:
        """Plays an episode, and ends the nodes after it unless they are kept."""
        known = tuple(self.world.settings)
        for key in episode.settings:
            if key not in known and not key.startswith(("param.", "arg.")):
                raise KeyError(f"the world does not know the setting `{key}`; it has {', '.join(known) or 'none'}, and there are "
                               "`param.NAME` and `arg.NAME`")
        try:
            return self._played(episode)
        except BaseException:
            self.running = False
            raise
        finally:
            if self.stack and not (self.running and self.reset_service):
                self.running = False
                self.stack.end_nodes(2.0)
                self.clock_ns = FIRST_CLOCK_NS - self.tick_ns

    def _played(self, episode: Episode) -> Kept:
        readings = self.world.reset(episode)
        self._announce(readings)
        self._start(episode, readings)
        signals = dict(self.world.signals)
        timed = [topic for topic, answer in self.answers.items() if answer.count]
        # In lock step these are columns without samples, so that requirements on them can stand beside others.
        signals.update({f"/latency{topic}.secs": "s" for topic in timed})
        signals["/latency/rig.secs"] = "s"
        self.untimed = [None] * (len(timed) + 1)
        kept = Kept(signals)
        self.inbox.taken()
        began_ns = self.clock_ns + self.tick_ns
        if self.real_time:
            self._play_in_real_time(kept, readings, Latencies(timed))
        else:
            self._play_in_lock_step(kept, readings, episode, began_ns)
        return kept

    def _play_in_lock_step(self, kept: Kept, readings: Optional[Readings], episode: Episode, began_ns: int) -> None:
        due = self._parameters_in_time(episode)
        for tick in range(self.ticks + 1):
            time_ns = tick * self.tick_ns
            self._no_answer_is_left(time_ns)
            while due and due[0][0] <= time_ns:
                self._set(due.popleft()[1])
            self.clock_ns += self.tick_ns
            self._publish(self.clock, Clock(_ros_time(self.clock_ns)))
            if self.settle_secs:
                time.sleep(self.settle_secs)
            began = time.monotonic()
            self._publish_readings(readings, kept, time_ns, began_ns)
            came = self._wait(time_ns)
            self.waits_secs.append(time.monotonic() - began)
            # Which of two topics is first is up to the machine; within a topic the order is the node's.
            for topic, message, _ in sorted(came, key=lambda one: one[0]):
                kept.message(time_ns, topic, message, began_ns)
            kept.row(time_ns, [*self.world.row(), *self.untimed])
            readings = self.world.step({topic: message for topic, message, _ in came})
            if readings is None:
                break
        # Nodes that answer more often than declared lag behind, and would go on.
        if not self.quiet_secs:
            time.sleep(LINGER_SECS)
        self._no_answer_is_left(time_ns)

    def _play_in_real_time(self, kept: Kept, readings: Optional[Readings], latencies: Latencies) -> None:
        began, began_ns = time.monotonic(), rospy.Time.now().to_nsec()
        heard = began
        for tick in range(self.ticks + 1):
            planned = began + tick * self.tick_ns / NS
            time.sleep(max(0.0, planned - time.monotonic()))
            now, self.clock_ns = time.monotonic(), rospy.Time.now().to_nsec()
            time_ns = round((now - began) * NS)
            latencies.published(self.clock_ns, now)
            self._publish_readings(readings, kept, time_ns, began_ns)
            cells = list(self.world.row())
            time.sleep(max(0.0, planned + self.tick_ns / NS - time.monotonic()))
            came = self.inbox.taken()
            for topic, message, at in came:
                latencies.answered(topic, message, at)
                kept.message(max(time_ns, round((at - began) * NS)), topic, message, began_ns)
                heard = at
            kept.row(time_ns, [*cells, *latencies.row(time.monotonic()), now - planned])
            if time.monotonic() - heard > self.limit_secs:
                raise TimeoutError(self._why("nothing was answered", time_ns))
            self._all_alive(time_ns)
            readings = self.world.step({topic: message for topic, message, _ in came})
            if readings is None:
                break
        kept.messages.sort(key=lambda one: one[0])

    def _publish_readings(self, readings: Optional[Readings], kept: Kept, time_ns: int, began_ns: int) -> None:
        for topic, message in sorted((readings or {}).items()):
            if topic not in self.publishers:
                raise KeyError(f"the world gives `{topic}` at {time_ns / NS:g} s, but did not at the beginning")
            if getattr(message, "_has_header", False):
                message.header.stamp = _ros_time(self.clock_ns)
            self._publish(self.publishers[topic], message)
            kept.message(time_ns, topic, message, began_ns)

    @staticmethod
    def _publish(publisher: rospy.Publisher, message: Any) -> None:
        # Small messages would wait for the acknowledgement of the one before, up to 40 ms.
        for queued in list(publisher.impl.connections):
            connection = getattr(getattr(queued, "_connection", queued), "socket", None)
            if isinstance(connection, socket.socket):
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        publisher.publish(message)

    # Waiting.

    def _wait(self, time_ns: int) -> List[Tuple[str, Any, float]]:
        """The tick's answers."""
        began = time.monotonic()
        with self.inbox.came:
            while True:
                now = time.monotonic()
                last = max([began] + [at for _, _, at in self.inbox.messages])
                missing = self.inbox.missing()
                if not missing and now - last >= self.quiet_secs:
                    break
                self._all_alive(time_ns)
                if now - began > self.limit_secs:
                    what = f"no answer on {', '.join(missing)}" if missing else "the nodes never became quiet"
                    raise TimeoutError(self._why(f"{what} within {self.limit_secs:g} s", time_ns))
                left = last + self.quiet_secs - now if not missing else 0.1
                self.inbox.came.wait(min(max(left, 0.0), 0.1))
        return self.inbox.taken()

    def _no_answer_is_left(self, time_ns: int) -> None:
        late = sorted({topic for topic, _, _ in self.inbox.messages})
        if late and not self.quiet_secs and any(self.answers[topic].count for topic in late):
            raise RuntimeError(f"more answers on {', '.join(late)} than declared came by {time_ns / NS:g} s, so which of them "
                               "counts is left to chance: declare their number, `Answer(type, count)`, or `quiet_secs`")
        if not self.quiet_secs:
            self.inbox.taken()

    def _all_alive(self, time_ns: int) -> None:
        """A node that answered or listened and is gone is an error at once, not at the time limit."""
        ended = self.stack.nodes.ended() if self.stack else None
        gone = [topic for topic, count in self.connected.items() if self._connections(topic) < count]
        if ended or gone:
            raise RuntimeError(self._why(ended or f"the node at {', '.join(gone)} has died or left", time_ns))

    def _connections(self, topic: str) -> int:
        ends = {**self.publishers, **self.inbox.subscribers}
        return ends[topic].get_num_connections()

    def _why(self, what: str, time_ns: int) -> str:
        """The reason, when, and what the nodes printed last."""
        said = f"; the nodes printed\n{self.stack.nodes.tail()}" if self.stack else ""
        return f"{what}, at {time_ns / NS:g} s of the episode{said}"

    # Beginning.

    def _announce(self, readings: Readings) -> None:
        for topic, message in readings.items():
            if topic not in self.publishers:
                self.publishers[topic] = rospy.Publisher(topic, type(message), queue_size=0)

    def _start(self, episode: Episode, readings: Readings) -> None:
        """Parameters, then nodes; over when all are connected, as what is published before is lost."""
        parameters = {key[len("param."):]: value for key, value in episode.settings.items() if key.startswith("param.")}
        master = rosgraph.Master(NAME)
        for name in self.set_before:
            if name not in parameters and master.hasParam(name):
                master.deleteParam(name)
        self.set_before = list(parameters)
        self._set(parameters)
        if self.running or self.master:
            self._reset()
        else:
            launched = isinstance(self.nodes, (str, Path))
            given = [f"{key[len('arg.'):]}:={value}" for key, value in episode.settings.items() if key.startswith("arg.")]
            if given and not launched:
                raise KeyError("`arg.NAME` are arguments of a launch file, but `nodes` are commands")
            self.stack.start_nodes(self.nodes, given)
            self.running = True
        self.connected: Dict[str, int] = {}
        self._connect(list(readings))
        for name, value in parameters.items():
            if master.getParam(name) != value:
                raise RuntimeError(f"the stimulus sets {name} to {value!r}, but the launch file to {master.getParam(name)!r}: take it "
                                   "out of there, or make it an `arg` and set `arg.NAME`")

    def _set(self, parameters: Mapping[str, Any]) -> None:
        for name, value in parameters.items():
            rosgraph.Master(NAME).setParam(name, value)

    def _parameters_in_time(self, episode: Episode) -> Deque[Tuple[int, Mapping[str, Any]]]:
        """The test's `set_param`, each with its time of the episode in nanoseconds; `after_secs` counts from the action before."""
        due, time_secs = deque(), 0.0
        for action in episode.actions:
            time_secs += action.get("after_secs") or 0.0
            if "set_param" in action:
                due.append((round(time_secs * NS), action["set_param"]))
        return due

    def _reset(self) -> None:
        if self.reset_service:
            from std_srvs.srv import Empty

            try:
                rospy.wait_for_service(self.reset_service, self.limit_secs)
                rospy.ServiceProxy(self.reset_service, Empty)()
            except (rospy.ROSException, rospy.ServiceException) as error:
                raise RuntimeError(self._why(f"the service {self.reset_service} failed: {error}", 0)) from error

    def _connect(self, sensors: Sequence[str]) -> None:
        """Until each sensor is heard by a node, each answer has a publisher, and all of these follow the clock."""
        topics = [*sensors, *self.answers]
        deadline = time.monotonic() + max(self.limit_secs, 10.0)
        while True:
            lacking = [topic for topic in topics if self._connections(topic) == 0]
            lacking = lacking or [topic for topic in self.answers if not self._is_sent_here(topic)]
            if not lacking and (self.clock is None or self._clock_is_followed(topics)):
                break
            if self.stack and self.stack.nodes.ended():
                raise RuntimeError(self._why(f"{self.stack.nodes.ended()} before it was connected", 0))
            if time.monotonic() > deadline:
                what = f"no node is connected to {', '.join(lacking)}" if lacking else "the nodes do not follow /clock"
                raise TimeoutError(self._why(what, 0))
            time.sleep(0.01)
        self.connected = {topic: self._connections(topic) for topic in topics}

    @staticmethod
    def _is_sent_here(topic: str) -> bool:
        """Whether a topic's publishers know of this node: it counts a connection before they do, and what they publish then is lost."""
        master = rosgraph.Master(NAME)
        publishers, _, _ = master.getSystemState()
        try:
            for node in dict(publishers).get(topic, []):
                with xmlrpc.client.ServerProxy(master.lookupNode(node)) as server:
                    _, _, connections = server.getBusInfo(NAME)
                if not any((one[1], one[2], one[4]) == (NAME, "o", topic) for one in connections):
                    return False
        except (OSError, rosgraph.MasterException):  # It has just ended.
            return False
        return topic in dict(publishers)

    def _clock_is_followed(self, topics: Sequence[str]) -> bool:
        publishers, subscribers, _ = rosgraph.Master(NAME).getSystemState()
        nodes = {node for listed in (publishers, subscribers) for topic, nodes in listed if topic in topics for node in nodes}
        following = {node for topic, nodes in subscribers if topic == "/clock" for node in nodes}
        return nodes - {NAME} <= following and self.clock.get_num_connections() >= len(following - {NAME})

    def close(self) -> None:
        """Ends the nodes and the master, if they were started here."""
        rospy.signal_shutdown("the rig ends")
        if self.stack:
            self.stack.close()


def shown(waits_secs: Sequence[float]) -> str:
    """Times of ticks in words: median, 95 %, greatest."""
    ordered = sorted(waits_secs)
    at = lambda share: 1000 * ordered[min(len(ordered) - 1, math.ceil(share * len(ordered)) - 1)]  # noqa: E731
    return f"{len(ordered)} ticks: median {at(0.5):.2f} ms, 95 % within {at(0.95):.2f} ms, greatest {at(1.0):.2f} ms"


def main(make: Callable[[], Ros1Rig], arguments: Optional[Sequence[str]] = None) -> None:
    """The rig as a program, as `corroborate_rig.main`. It is made once, and everything it started ends in all cases."""
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    rig: List[Ros1Rig] = []

    def run(episode: Episode) -> Any:
        if not rig:
            rig.append(make())
        return rig[0].run(episode)

    try:
        corroborate_rig.main(run, arguments)
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        for one in rig:
            one.close()
