"""A ROS master of one's own, and nodes as somebody else starts them: by a launch file or a command. What was started ends.

Every process carries a mark in its environment that its children inherit, so those that `roslaunch` puts into sessions of
their own are found, too. If this process is killed, the kernel ends `roscore` and `roslaunch`, which ends the nodes.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import uuid
import xmlrpc.client
from pathlib import Path
from typing import Any, Dict, List, Optional, Sequence, Union

Command = Union[str, Sequence[Sequence[str]]]

_MARK = "CORROBORATE_ROS1"
_LIBC = ctypes.CDLL(None, use_errno=True)
_PR_SET_PDEATHSIG = 1
_ATTEMPTS = 5
_CALLER = "/corroborate_stack"


def _end_with_parent() -> None:
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def port_is_free(port: int) -> bool:
    """Whether a server could listen on a port of this machine."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind(("", port))
        except OSError:
            return False
    return True


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("", 0))
        return probe.getsockname()[1]


class Group:
    """Processes that are started, watched and ended together; what they print is kept."""

    def __init__(self, name: str, room: Path, environment: Dict[str, str]):
        self.name = name
        self.mark = f"{_MARK}={name}-{uuid.uuid4().hex}"
        self.environment = {**environment, _MARK: self.mark.partition("=")[2]}
        self.log = room / f"{name}.log"
        self.started: List[subprocess.Popen] = []

    def start(self, words: Sequence[str]) -> subprocess.Popen:
        """One more process of the group."""
        with open(self.log, "ab") as log:
            try:
                process = subprocess.Popen(
                    list(words), env=self.environment, stdin=subprocess.DEVNULL, stdout=log, stderr=subprocess.STDOUT,
                    start_new_session=True, preexec_fn=_end_with_parent,
                )
            except OSError as error:
                raise RuntimeError(f"`{words[0]}` could not be started: {error.strerror}") from error
        self.started.append(process)
        return process

    def ended(self) -> Optional[str]:
        """Which of the processes that were started has ended by itself, and how; None while all run."""
        for process in self.started:
            code = process.poll()
            if code is not None:
                return f"`{process.args[0]}` ended {'by signal ' + str(-code) if code < 0 else 'with code ' + str(code)}"
        return None

    def tail(self, lines: int = 16) -> str:
        """The last lines that were printed, indented."""
        text = self.log.read_text(encoding="utf-8", errors="replace") if self.log.exists() else ""
        last = [line for line in text.splitlines() if line.strip()][-lines:]
        return "\n".join(f"    {line}" for line in last) or "    (printed nothing)"

    def running(self) -> List[int]:
        """Process numbers of the group, those of children and their children, too."""
        found = []
        for entry in os.listdir("/proc"):
            if entry.isdigit():
                try:
                    with open(f"/proc/{entry}/environ", "rb") as file:
                        if self.mark.encode() in file.read().split(b"\0"):
                            found.append(int(entry))
                except OSError:  # It has just ended, or is not ours.
                    continue
        return found

    def end(self, grace_secs: float) -> None:
        """Asks all to end (SIGINT, as Ctrl-C does), and kills what is left after the grace."""
        deadline = time.monotonic() + grace_secs
        if grace_secs > 0:
            self._send(signal.SIGINT)
        while time.monotonic() < deadline and self._left():
            time.sleep(0.02)
        # Killing one may take the time in which another starts a child.
        for _ in range(_ATTEMPTS):
            if not self._left():
                break
            self._send(signal.SIGKILL)
            time.sleep(0.02)
        for process in self.started:
            process.wait()
        self.started.clear()

    def _left(self) -> List[int]:
        for process in self.started:
            process.poll()
        return self.running()

    def _send(self, which: int) -> None:
        for number in self.running():
            try:
                os.kill(number, which)
            except ProcessLookupError:
                continue


class Stack:
    """`roscore` on a port of its own with the nodes under test. Use it with `with`, or call `close`."""

    def __init__(self, port: Optional[int] = None, limit_secs: float = 20.0, package_path: Sequence[Union[str, Path]] = ()):
        for program in ("roscore", "roslaunch"):
            if shutil.which(program) is None:
                raise RuntimeError(f"`{program}` was not found; install Debian's python3-roslaunch and rosout, or source ROS 1")
        if port is not None and not port_is_free(port):
            raise RuntimeError(f"port {port} is already in use; end what listens there, or leave `port` out to have a free one")
        self.room = Path(tempfile.mkdtemp(prefix="corroborate-ros1-"))
        paths = [str(Path(path).resolve()) for path in package_path] + [os.environ.get("ROS_PACKAGE_PATH", "")]
        self.environment = {
            **os.environ, "ROS_HOME": str(self.room), "ROS_LOG_DIR": str(self.room / "log"), "ROS_HOSTNAME": "localhost",
            "PYTHONUNBUFFERED": "1",
            # Nodes in Python get the interpreter that has ROS, as this program did.
            "PATH": f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}",
            "ROS_PACKAGE_PATH": ":".join(filter(None, paths)),
        }
        self.environment.pop("ROS_IP", None)
        self.nodes = Group("nodes", self.room, self.environment)
        try:
            self._start_master(port, limit_secs)
        except BaseException:
            self.close()
            raise

    def _start_master(self, wanted: Optional[int], limit_secs: float) -> None:
        for _ in range(_ATTEMPTS):
            port = wanted or _free_port()
            self.uri = f"http://localhost:{port}"
            self.environment["ROS_MASTER_URI"] = self.nodes.environment["ROS_MASTER_URI"] = self.uri
            self.core = Group("roscore", self.room, self.environment)
            self.core.start(["roscore", "-p", str(port)])
            if self._is_up(limit_secs):
                return
            said = self.core.tail()
            self.core.end(0)
            if wanted:
                break
        raise RuntimeError(f"`roscore -p {port}` did not come up within {limit_secs:g} s; it printed\n{said}")

    def _is_up(self, limit_secs: float) -> bool:
        """Whether the master answers, with its log, and is ours: another might have taken the port."""
        deadline = time.monotonic() + limit_secs
        while time.monotonic() < deadline and not self.core.ended():
            try:
                if self.master("lookupNode", "/rosout") and self.master("getPid") in self.core.running():
                    return True
            except (OSError, RuntimeError, xmlrpc.client.Error):
                pass
            time.sleep(0.05)
        return False

    def master(self, method: str, *arguments: Any) -> Any:
        """A call of the master's interface (`getParam`, `lookupNode`, ...); what it refuses is an error."""
        try:
            with xmlrpc.client.ServerProxy(self.uri) as server:
                code, message, value = getattr(server, method)(_CALLER, *arguments)
        except OSError as error:
            raise RuntimeError(f"the ROS master at {self.uri} does not answer ({error}); roscore printed\n{self.core.tail()}") from error
        if code != 1:
            raise RuntimeError(f"the ROS master refused {method}{arguments}: {message}")
        return value

    def start_nodes(self, nodes: Command, arguments: Sequence[str] = ()) -> None:
        """Starts the nodes: a launch file with arguments `NAME:=VALUE`, or commands."""
        if isinstance(nodes, (str, Path)):
            if not Path(nodes).is_file():
                raise FileNotFoundError(f"the launch file {nodes} does not exist")
            self.nodes.start(["roslaunch", "--screen", str(nodes), *arguments])
            return
        for words in nodes:
            self.nodes.start([*words, *arguments])

    def end_nodes(self, grace_secs: float) -> None:
        """Ends the nodes, and takes out of the master what those that were killed have left there."""
        self.nodes.end(grace_secs)
        publishers, subscribers, services = self.master("getSystemState")
        with xmlrpc.client.ServerProxy(self.uri) as server:
            for listed, method, lookup in (
                (publishers, server.unregisterPublisher, "lookupNode"), (subscribers, server.unregisterSubscriber, "lookupNode"),
                (services, server.unregisterService, "lookupService"),
            ):
                for name, callers in listed:
                    for caller in (caller for caller in callers if caller not in ("/rosout", "/corroborate_rig")):
                        method(caller, name, self.master(lookup, name if lookup == "lookupService" else caller))

    def close(self) -> None:
        """Ends everything that was started here, and removes its logs."""
        self.nodes.end(0.5)
        if hasattr(self, "core"):
            self.core.end(1.0)
        shutil.rmtree(self.room, ignore_errors=True)

    def __enter__(self) -> "Stack":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
