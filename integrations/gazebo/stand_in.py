"""A stand-in for Gazebo's server behind gz-transport's Python interface: real messages, made up physics, no network.

It does what makes lock step hard in the real one: requests are queued and answered at once, steps are carried out later in another
thread, poses are published at a rate of the wall clock only, while it stands, too, and of requests that are carried out together the
last one says whether there is a reset. A cart (model `cart`, 2 kg) moves along x by the force (N) of `/cart/cmd_force`.
"""

from __future__ import annotations

import threading
import time

from gz.msgs10.boolean_pb2 import Boolean
from gz.msgs10.double_pb2 import Double
from gz.msgs10.pose_v_pb2 import Pose_V
from gz.msgs10.world_control_pb2 import WorldControl

MASS_KG = 2.0


class Server:
    """One world; all nodes of the process talk to it."""

    def __init__(self, name="w", step_ns=1_000_000, pose_hertz=60.0, delay_secs=0.0, broadcasts=True):
        self.name, self.step_ns, self.period_secs, self.delay_secs, self.broadcasts = name, step_ns, 1 / pose_hertz, delay_secs, broadcasts
        self.lock = threading.Lock()
        self.requests, self.subscribers, self.warnings = [], {}, []
        self.pending, self.published_at, self.running, self.refuses = 0, 0.0, True, False
        self._begin()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    def _begin(self):
        self.steps, self.x_m, self.v_m_s, self.force_n = 0, 0.0, 0.0, 0.0

    def _run(self):
        while self.running:
            with self.lock:
                rewind = self._take_requests()
                if rewind:
                    self._begin()
                moved = self.pending > 0
                if moved:
                    self.pending -= 1
                    self.steps += 1
                    self.v_m_s += self.force_n / MASS_KG * self.step_ns / 1e9
                    self.x_m += self.v_m_s * self.step_ns / 1e9
            self._broadcast()
            time.sleep(0.0 if moved else 0.001)

    def _take_requests(self):
        rewind = False
        for control in self.requests:
            self.pending += control.multi_step if control.pause else 0
            rewind = control.HasField("reset") and control.reset.all
        self.requests.clear()
        return rewind

    def _broadcast(self):
        now = time.monotonic()
        if not self.broadcasts or now - self.published_at < self.period_secs:
            return
        self.published_at = now
        message = Pose_V()
        message.header.stamp.sec, message.header.stamp.nsec = divmod(self.steps * self.step_ns, 10**9)
        for name, x_m in (("cart", self.x_m), ("wheel", 0.1), ("wheel", -0.1)):
            pose = message.pose.add(name=name)
            pose.position.x, pose.position.z, pose.orientation.w = x_m, 0.2, 1.0
        for callback in self.subscribers.get(f"/world/{self.name}/dynamic_pose/info", []):
            callback(Pose_V.FromString(message.SerializeToString()))

    def control(self, request):
        """The service; its answer does not mean that anything was done."""
        time.sleep(self.delay_secs)
        if request.seed:
            self.warnings.append("Changing seed is not supported.")
        with self.lock:
            self.requests.append(request)
        return Boolean(data=not self.refuses)

    def close(self):
        """Ends its thread."""
        self.running = False
        self.thread.join()


class Node:
    """The methods of `gz.transport13.Node`, with their parameters."""

    server = None

    def subscribe(self, msg_type, topic, callback):
        """Calls back for each message of a topic."""
        assert msg_type is Pose_V
        self.server.subscribers.setdefault(topic, []).append(callback)
        return True

    def advertise(self, topic, msg_type):
        """A publisher."""
        assert (topic, msg_type) == ("/cart/cmd_force", Double)
        return Publisher(self.server)

    def request(self, service, request, request_type, response_type, timeout):
        """(whether it was answered, the answer); messages go as bytes."""
        assert isinstance(timeout, int) and (request_type, response_type) == (WorldControl, Boolean)
        if service != f"/world/{self.server.name}/control":
            return False, Boolean()
        reply = self.server.control(WorldControl.FromString(request.SerializeToString()))
        return True, Boolean.FromString(reply.SerializeToString())


class Publisher:
    """Of forces."""

    def __init__(self, server):
        self.server = server

    def publish(self, message):
        """At once."""
        self.server.force_n = Double.FromString(message.SerializeToString()).data
