"""Runs with a Python that has rospy (Debian: /usr/bin/python3). A process can be one node of ROS, so each rig is a program here."""

import csv
import json
import os
import re
import shutil
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import unittest
import uuid
from pathlib import Path

HERE = Path(__file__).resolve().parent
EXAMPLE = HERE / "example"
sys.path.insert(0, str(HERE))

from ros1_rig import Kept, Latencies, Ros1Rig, shown  # noqa: E402
from ros1_stack import Stack, port_is_free  # noqa: E402
from std_msgs.msg import Float64, Header  # noqa: E402

# A world that counts ticks and a node that doubles what it hears; each test says what of it is otherwise.
RIG = """
import json, os, sys
sys.path.insert(0, {here!r})
from ros1_rig import Answer, Ros1Rig, main
from std_msgs.msg import Float64

class World:
    signals = {{"/truth/count": "", "/truth/heard": ""}}
    settings = ("start",)
    def reset(self, episode):
        self.count, self.heard = episode.number("start", 0.0), None
        return {{"/sense": Float64(self.count)}}
    def step(self, commands):
        self.count += 1
        if "/act" in commands:
            self.heard = commands["/act"].data
        return {{"/sense": Float64(self.count)}}
    def row(self):
        return self.count, self.heard

told = json.loads(os.environ["RIG"])
nodes = told.pop("nodes", [[sys.executable, "node.py"]])
answers = {{"/act": Answer(Float64, told.pop("count", 1))}}
main(lambda: Ros1Rig(World(), nodes, answers, **{{"tick_secs": 0.05, "duration_secs": 1.0, **told}}))
"""
NODE = """
import os, sys, time
import rospy
from std_msgs.msg import Float64

def heard(message):
    {body}

rospy.init_node("doubler")
out = rospy.Publisher("/act", Float64, queue_size=10)
rospy.Subscriber("/sense", Float64, heard, tcp_nodelay=True)
{more}
rospy.spin()
"""
DOUBLES = "out.publish(2 * message.data)"


class RigCase(unittest.TestCase):
    def setUp(self) -> None:
        room = tempfile.TemporaryDirectory()
        self.addCleanup(room.cleanup)
        self.room = Path(room.name)
        (self.room / "rig.py").write_text(RIG.format(here=str(HERE)), encoding="utf-8")
        self.node(DOUBLES)
        # What the rig starts inherits it, whatever sessions it makes.
        self.mark = uuid.uuid4().hex
        self.addCleanup(lambda: [os.kill(one, signal.SIGKILL) for one in self.left_running()])

    def node(self, body: str, more: str = "") -> None:
        (self.room / "node.py").write_text(NODE.format(body=body, more=more), encoding="utf-8")

    def left_running(self) -> list:
        found = []
        for entry in filter(str.isdigit, os.listdir("/proc")):
            try:
                if self.mark.encode() in Path(f"/proc/{entry}/environ").read_bytes():
                    found.append(int(entry))
            except OSError:
                continue
        return found

    def stimulus(self, actions=(), **settings) -> str:
        path = self.room / f"{uuid.uuid4().hex}.json"
        path.write_text(json.dumps({"test": {"name": "t", "actions": list(actions)}, "settings": settings}), encoding="utf-8")
        return str(path)

    def started(self, words, **told) -> subprocess.Popen:
        environment = {**os.environ, "RIG": json.dumps(told), "TEST_MARK": self.mark}
        return subprocess.Popen(
            words, cwd=self.room, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )

    def ran(self, words, said="", **told):
        """A rig's program to its end: output and errors. Whatever happened, nothing of it may still run."""
        process = self.started(words, **told)
        output, errors = process.communicate(said, timeout=120)
        self.assertEqual(self.left_running(), [], errors)
        return process.returncode, output, errors

    def once(self, stimulus=None, leaves="csv", seed=1, **told):
        """One episode: the rows, or the errors if it failed."""
        path = self.room / f"{uuid.uuid4().hex}.{leaves}"
        words = [sys.executable, "rig.py", stimulus or self.stimulus(), str(seed), str(path)]
        code, _, errors = self.ran(words, **told)
        if code != 0:
            self.assertFalse(path.exists())
            return errors
        with open(path, encoding="utf-8") as file:
            return list(csv.DictReader(file))


class TestLockStep(RigCase):
    def test_each_tick_waits_for_its_answer(self) -> None:
        self.node("time.sleep(0.02 if message.data == 7 else 0); " + DOUBLES)
        rows = self.once(self.stimulus(start=3.0))
        self.assertEqual([float(row["time_secs"]) for row in rows], [tick / 20 for tick in range(21)])
        self.assertEqual([float(row["/truth/count"]) for row in rows], [3.0 + tick for tick in range(21)])
        # The answer to what was seen at a tick acts in the next: even where the node was slower than the tick is long.
        self.assertEqual([row["/truth/heard"] for row in rows], [""] + [repr(2 * (3.0 + tick)) for tick in range(20)])

    def test_the_clock_is_simulated_and_stamps_are_its(self) -> None:
        self.node("out.publish(rospy.Time.now().to_sec())")
        rows = self.once(settle_secs=0.02)
        self.assertEqual([row["/truth/heard"] for row in rows[1:]], [repr(round(1 + 0.05 * tick, 9)) for tick in range(20)])

    def test_several_answers_a_tick_have_to_be_declared(self) -> None:
        self.node("out.publish(-1.0); time.sleep(0.003); " + DOUBLES)
        rows = self.once(count=2)
        self.assertEqual([float(row["/truth/heard"]) for row in rows[1:]], [2.0 * tick for tick in range(20)])
        self.assertIn("more answers on /act than declared", self.once(duration_secs=5.0))

    def test_a_quiet_time_ends_ticks_that_no_message_ends(self) -> None:
        # Every other reading is answered, so that no number of answers a tick is right.
        self.node("message.data % 2 or " + DOUBLES)
        rows = self.once(count=0, quiet_secs=0.15)
        self.assertEqual([row["/truth/heard"] for row in rows], [""] + [repr(4.0 * (tick // 2)) for tick in range(20)])

    def test_parameters_are_set_before_and_during_an_episode(self) -> None:
        self.node('out.publish(rospy.get_param("/gain") * message.data)')
        action = {"after_secs": 0.5, "set_param": {"/gain": 10.0}}
        rows = self.once(self.stimulus([action], **{"param./gain": 3.0}))
        self.assertEqual([float(row["/truth/heard"]) for row in rows[1:]], [(3.0 if tick < 10 else 10.0) * tick for tick in range(20)])

    def test_episodes_in_turn_and_alone_leave_the_same_bytes(self) -> None:
        """Nodes that are reset, nodes that are started anew, and a bag with messages' stamps and numbers."""
        robot, way = str(EXAMPLE / "robot.py"), {"crate.x_m": 2.2, "crate.appears_m": 1.3, "arg.speed_m_s": 0.8}
        stimuli = [self.stimulus(**way, **{"param./stopper/stop_distance_m": stop}) for stop in (0.5, 0.9, 0.5)]
        for leaves in ("csv", "bag"):
            paths = [self.room / f"{number}.{leaves}" for number in range(3)]
            asked = [
                json.dumps({"type": "episode", "stimulus": stimulus, "seed": seed, "recording": str(path)})
                for stimulus, seed, path in zip(stimuli, (7, 8, 7), paths)
            ]
            for option in (["--reset"], []):
                code, output, errors = self.ran([sys.executable, robot, *option], "\n".join(asked) + "\n")
                self.assertEqual([json.loads(line)["type"] for line in output.splitlines()], ["recorded"] * 3, errors)
                found = [path.read_bytes() for path in paths]
                self.assertEqual(found[0], found[2])
                self.assertNotEqual(found[0], found[1])
                if not option:
                    self.assertEqual(found[0], before)
                before = found[0]
            self.assertEqual(code, 0)


class TestFailures(RigCase):
    def test_a_node_that_dies_is_told_with_its_last_words(self) -> None:
        self.node('message.data == 5 and (print("out of memory", flush=True), os._exit(9)); ' + DOUBLES)
        began = time.monotonic()
        errors = self.once(limit_secs=60.0)
        self.assertRegex(errors, r"`.*python3.*` ended with code 9, at 0\.25 s of the episode|the node at .* has died or left, at 0\.25 s")
        self.assertIn("out of memory", errors)
        self.assertLess(time.monotonic() - began, 30)

    def test_a_node_that_a_launch_file_started_and_that_dies_is_noticed(self) -> None:
        (self.room / "pkg/scripts").mkdir(parents=True)
        (self.room / "pkg/package.xml").write_text((EXAMPLE / "base_stop/package.xml").read_text().replace("base_stop", "pkg"))
        self.node("message.data == 5 and os._exit(9); " + DOUBLES)
        script = self.room / "pkg/scripts/node.py"
        script.write_text("#!/usr/bin/env python3\n" + (self.room / "node.py").read_text())
        script.chmod(0o755)
        (self.room / "a.launch").write_text('<launch><node pkg="pkg" type="node.py" name="doubler"/></launch>')
        errors = self.once(nodes="a.launch", package_path=[str(self.room)], limit_secs=60.0)
        self.assertRegex(errors, r"the node at .*/act.* has died or left, at 0\.25 s")

    def test_a_master_that_dies_is_told(self) -> None:
        self.node("message.data == 5 and os.kill(rospy.get_master().getPid()[2], 9); " + DOUBLES)
        self.assertRegex(self.once(), "the ROS master at http://localhost:[0-9]+ does not answer")

    def test_a_node_that_never_answers_ends_at_the_limit(self) -> None:
        self.node("message.data == 4 or " + DOUBLES)
        self.assertIn("no answer on /act within 1 s, at 0.2 s of the episode", self.once(limit_secs=1.0))

    def test_a_node_that_does_not_listen_is_named_by_its_topic(self) -> None:
        self.node(DOUBLES)
        text = (self.room / "node.py").read_text().replace('"/sense"', '"/sens"')
        (self.room / "node.py").write_text(text)
        self.assertIn("no node is connected to /sense", self.once(limit_secs=1.0))

    def test_a_launch_file_may_not_undo_the_stimulus(self) -> None:
        nodes = [["roslaunch", "a.launch"], [sys.executable, "node.py"]]
        (self.room / "a.launch").write_text(
            '<launch><param name="/gain" value="2.5"/><param name="/late" value="1"/>'
            '<node pkg="rosout" type="rosout" name="other"/></launch>'
        )
        # The node comes up only after the launch file has set its parameters.
        text = (self.room / "node.py").read_text()
        wait = 'while not rospy.has_param("/late"): time.sleep(0.02)\nout = '
        (self.room / "node.py").write_text(text.replace("out = ", wait))
        errors = self.once(self.stimulus(**{"param./gain": 3.0}), nodes=nodes)
        self.assertIn("the stimulus sets /gain to 3.0, but the launch file to 2.5", errors)

    def test_mistakes_are_told_plainly(self) -> None:
        for told, words in (
            ({"count": 0}, "nothing says when a tick is over"),
            ({"tick_secs": 0.0}, "`tick_secs` must be positive .got 0., and `duration_secs` at least as long .got 1."),
            ({"nodes": "none.launch"}, "the launch file none.launch does not exist"),
            ({"nodes": [["no-such-program"]]}, "`no-such-program` could not be started: No such file"),
            ({"nodes": None}, "`nodes` must be a launch file or commands"),
            ({"master": "http://localhost:1", "nodes": None, "real_time": True}, "no ROS master answers at http://localhost:1"),
        ):
            with self.subTest(words):
                self.assertRegex(self.once(**told), words)
        self.assertIn("does not know the setting `stat`; it has start", self.once(self.stimulus(stat=1.0)))
        self.assertIn("`arg.NAME` are arguments of a launch file", self.once(self.stimulus(**{"arg.x": 1.0})))
        self.assertIn("leaves `csv` or `bag`, not `mcap`", self.once(leaves="mcap"))

    def test_a_port_that_is_taken_is_told(self) -> None:
        with socket.socket() as taken:
            taken.bind(("", 0))
            taken.listen()
            port = taken.getsockname()[1]
            self.assertFalse(port_is_free(port))
            self.assertIn(f"port {port} is already in use", self.once(port=port))

    def test_a_rig_that_is_ended_from_outside_leaves_nothing(self) -> None:
        self.node("time.sleep(100)")
        for how, within in ((signal.SIGTERM, 10.0), (signal.SIGKILL, 30.0)):
            process = self.started([sys.executable, "rig.py", self.stimulus(), "1", str(self.room / "x.csv")], limit_secs=90.0)
            deadline = time.monotonic() + 30
            while not any(b"node.py" in Path(f"/proc/{one}/cmdline").read_bytes() for one in self.left_running()):
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.1)
            time.sleep(1.0)
            process.send_signal(how)
            began = time.monotonic()
            process.communicate(timeout=60)
            while self.left_running() and time.monotonic() - began < within:
                time.sleep(0.05)
            self.assertEqual(self.left_running(), [], how)


class TestRealTime(RigCase):
    def test_the_latency_of_each_answer_is_a_signal(self) -> None:
        self.node("time.sleep(0.02); " + DOUBLES)
        rows = self.once(real_time=True)
        latencies = [float(row["/latency/act.secs [s]"]) for row in rows]
        self.assertEqual(len(latencies), 21)
        self.assertGreaterEqual(min(latencies), 0.02)
        self.assertLess(statistics.median(latencies), 0.05)
        self.assertGreaterEqual(min(float(row["/latency/rig.secs [s]"]) for row in rows), 0.0)

    def test_an_answer_that_does_not_come_is_late_while_it_is_waited_for(self) -> None:
        self.node("message.data == 10 and time.sleep(0.32); " + DOUBLES)
        latencies = [float(row["/latency/act.secs [s]"]) for row in self.once(real_time=True)]
        self.assertGreaterEqual(max(latencies), 0.32)
        # It shows before it comes: with its age, tick by tick.
        self.assertGreaterEqual(latencies[12], 0.12)
        self.assertGreater(latencies[13], latencies[12])
        self.assertLess(statistics.median(latencies[:9]), 0.05)

    def test_nodes_that_hang_end_the_episode(self) -> None:
        self.node("message.data > 4 or " + DOUBLES)
        self.assertIn("nothing was answered", self.once(real_time=True, limit_secs=1.0, duration_secs=30.0))

    def test_a_robot_with_a_master_of_its_own_is_met_there(self) -> None:
        with Stack() as robot:
            robot.master("setParam", "/use_sim_time", False)
            robot.start_nodes([[sys.executable, str(self.room / "node.py")]])
            rows = self.once(real_time=True, master=robot.uri, nodes=None)
            self.assertEqual(float(rows[-1]["/truth/heard"]), 38.0)
            # The robot goes on.
            self.assertIsNone(robot.nodes.ended())
            self.assertFalse(robot.master("getParam", "/use_sim_time"))

    def test_latencies_are_of_the_readings_that_were_answered(self) -> None:
        one = Latencies(["/a"])
        for stamp, at in ((1, 10.0), (2, 11.0), (3, 12.0)):
            one.published(stamp, at)
        one.answered("/a", Float64(0), 12.5)
        self.assertEqual(one.row(12.5), [2.5])
        one.answered("/b", Float64(0), 13.0)
        self.assertEqual(one.row(13.5), [2.5])
        stamped = type("Stamped", (), {"header": Header()})()
        stamped.header.stamp.nsecs = 3
        one.answered("/a", stamped, 13.75)
        self.assertEqual(one.row(14.0), [1.75])
        self.assertEqual(one.row(20.0), [None])
        # An answer to nothing that was asked has no latency.
        one.answered("/a", stamped, 21.0)
        self.assertEqual(one.row(21.0), [None])


class TestStudy(RigCase):
    def test_the_example_gives_its_report(self) -> None:
        program = shutil.which("corroborate")
        if program is None:
            self.skipTest("`corroborate` is not on the path")
        results = self.room / "results"
        done = subprocess.run([program, "run", str(EXAMPLE), "--out", str(results)], capture_output=True, text=True, timeout=400)
        # Nothing is violated, and without trials of the system nothing is decided.
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        self.assertGreater((results / "report.html").stat().st_size, 10_000)
        self.assertEqual(self.counts(results, "L1"), {"clear": (40, 40), "stops": (40, 40)})
        self.assertEqual(self.counts(results, "H1"), {"clear": (2, 2), "stops": (2, 2), "prompt": (2, 2)})
        self.assertEqual(self.counts(results, "F1"), {"clear": (0, 12), "stops": (8, 12)})
        twice = [program, "engines", str(EXAMPLE), "L1", "-n", "2", "--determinism"]
        same = subprocess.run(twice, capture_output=True, text=True, timeout=400)
        self.assertEqual((same.returncode, same.stdout.count("the same again")), (0, 2), same.stdout + same.stderr)

    @staticmethod
    def counts(results: Path, entry: str) -> dict:
        """How often each requirement that was covered held, of how many episodes."""
        findings = json.loads((results / "evidence" / f"{entry}.json").read_text(encoding="utf-8"))["content"]["findings"]
        shown = {one["subject"]["id"]: (one["measure"].get("count"), one["measure"].get("trials")) for one in findings}
        return {key: value for key, value in shown.items() if value[1]}


if __name__ == "__main__":
    unittest.main()
