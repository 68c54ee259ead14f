"""Writes moving frames with the `rosbags` library, and where things are by SciPy.

    pip install rosbags==0.11.9 scipy
    python make_frames.py frames

`frames.bag` (ROS 1) and `frames` (rosbag2, MCAP) hold the same: `world` to `base` at 20 Hz, `base` to
`arm` at 33 Hz, `arm` to `hand` static, and a point that is told in `base` at 10 Hz. `expected.csv`
has the position and the rotation of `hand` in `world` at each sample of the moving frames from the
time on at which both are known, and the point in `world`. Rotations are interpolated by
`scipy.spatial.transform.Slerp`, translations by `numpy.interp`, at times that are whole nanoseconds.
"""

import shutil
import sys
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.spatial.transform import Rotation, Slerp

START = 1_700_000_000_000_000_000
FOLDER = Path(sys.argv[1])
RANDOM = np.random.default_rng(7)


class Frame:
    def __init__(self, parent, child, times):
        self.parent, self.child, self.times = parent, child, times
        self.moves = RANDOM.uniform(-1, 1, (len(times), 3))
        self.turns = Rotation.random(len(times), rng=RANDOM)

    def at(self, nanos):
        secs = (self.times - START) / 1e9
        at = (nanos - START) / 1e9
        move = np.array([np.interp(at, secs, self.moves[:, axis]) for axis in range(3)])
        return move, Slerp(secs, self.turns)(at)


BASE = Frame("world", "base", START + np.arange(0, 2_000_000_000, 50_000_000))
ARM = Frame("base", "arm", START + 3_000_001 + np.arange(0, 1_980_000_000, 30_303_030))
HAND_MOVE, HAND_TURN = np.array([0.1, -0.2, 0.3]), Rotation.from_rotvec([0.3, 0.2, -0.5])
POINTS = START + 17_000_000 + np.arange(0, 1_900_000_000, 100_000_000)


def hand_in_world(nanos):
    move, turn = HAND_MOVE, HAND_TURN
    for frame in (ARM, BASE):
        frame_move, frame_turn = frame.at(nanos)
        move, turn = frame_move + frame_turn.apply(move), frame_turn * turn
    return move, turn


def point_in_base(nanos):
    secs = (nanos - START) / 1e9
    return np.array([np.sin(secs), np.cos(secs), secs])


def messages(store, is_ros1):
    if is_ros1:
        text = "geometry_msgs/TransformStamped[] transforms\n"
        store.register(get_types_from_msg(text, "tf2_msgs/msg/TFMessage"))
    types = store.types
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    header, time = types["std_msgs/msg/Header"], types["builtin_interfaces/msg/Time"]
    stamped, tf = types["geometry_msgs/msg/TransformStamped"], types["tf2_msgs/msg/TFMessage"]
    transform = types["geometry_msgs/msg/Transform"]
    point, point_stamped = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/PointStamped"]

    def head(nanos, frame):
        stamp = time(int(nanos // 10**9), int(nanos % 10**9))
        return header(0, stamp, frame) if is_ros1 else header(stamp, frame)

    def message(parent, child, nanos, move, turn):
        pose = transform(vector(*move.tolist()), quaternion(*turn.as_quat().tolist()))
        return tf([stamped(head(nanos, parent), child, pose)])

    yield "/tf_static", tf, START, message("arm", "hand", START, HAND_MOVE, HAND_TURN)
    rows = []
    for frame in (BASE, ARM):
        for nanos, move, turn in zip(frame.times, frame.moves, frame.turns):
            # Transforms are received up to 9 ms after they were measured.
            received = nanos + int(RANDOM.integers(0, 9_000_000))
            rows.append((received, "/tf", tf, message(frame.parent, frame.child, nanos, move, turn)))
    for nanos in POINTS:
        told = point_stamped(head(nanos, "base"), point(*point_in_base(nanos).tolist()))
        rows.append((nanos + 2_000_000, "/person", point_stamped, told))
    for received, topic, kind, told in sorted(rows, key=lambda row: row[0]):
        yield topic, kind, int(received), told


def write(writer, store, is_ros1):
    topics = {}
    with writer:
        for topic, kind, nanos, message in messages(store, is_ros1):
            name = kind.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, name, typestore=store)
            serialize = store.serialize_ros1 if is_ros1 else store.serialize_cdr
            writer.write(topics[topic], nanos, serialize(message, name))


shutil.rmtree(FOLDER, ignore_errors=True)
FOLDER.mkdir()
write(Writer1(FOLDER / "frames.bag"), get_typestore(Stores.ROS1_NOETIC), True)
write(
    Writer2(FOLDER / "frames", version=9, storage_plugin=StoragePlugin.MCAP),
    get_typestore(Stores.ROS2_HUMBLE),
    False,
)
with open(FOLDER / "expected.csv", "w", encoding="utf-8") as file:
    file.write("what,nanos,x,y,z,w\n")
    first = max(BASE.times[0], ARM.times[0])
    last = min(BASE.times[-1], ARM.times[-1])
    for nanos in sorted({*BASE.times.tolist(), *ARM.times.tolist()}):
        if first <= nanos <= last:
            move, turn = hand_in_world(nanos)
            file.write(f"position,{nanos},{','.join(map(repr, move.tolist()))},0\n")
            quaternion = turn.as_quat(canonical=True).tolist()
            file.write(f"rotation,{nanos},{','.join(map(repr, quaternion))}\n")
    for nanos in POINTS.tolist():
        move, turn = BASE.at(nanos)
        seen = (move + turn.apply(point_in_base(nanos))).tolist()
        file.write(f"point,{nanos},{','.join(map(repr, seen))},0\n")
