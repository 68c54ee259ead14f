"""Writes the recordings in the folder `rosbags` with the `rosbags` library, and what they say in `expected.csv`.

    pip install rosbags==0.11.9
    python make_rosbags.py rosbags

The same messages go into each recording. `expected.csv` has a row for each number and text in each message.
"""

import shutil
import sqlite3
import sys
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START_NANOS = 1_700_000_000_000_000_000
FOLDER = Path(sys.argv[1])


def messages(store, is_ros1):
    """(topic, type, nanos, message) in the order of time."""
    types = store.types
    time, header = types["builtin_interfaces/msg/Time"], types["std_msgs/msg/Header"]
    joint_state, transform = types["sensor_msgs/msg/JointState"], types["geometry_msgs/msg/Transform"]
    vector, quaternion = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"]
    stamped, tf = types["geometry_msgs/msg/TransformStamped"], types["tf2_msgs/msg/TFMessage"]
    flag, text = types["std_msgs/msg/Bool"], types["std_msgs/msg/String"]
    scan = types["sensor_msgs/msg/LaserScan"]

    def head(nanos, frame, seq):
        stamp = time(nanos // 10**9, nanos % 10**9)
        return header(seq, stamp, frame) if is_ros1 else header(stamp, frame)

    for i in range(12):
        nanos = START_NANOS + i * 100_000_000
        names = ["shoulder", "elbow", "wrist"][: 1 + i % 3]
        values = [np.array([k + factor * i / 7 for k in range(len(names))]) for factor in (1, -2, 0.5)]
        yield "/joint_states", joint_state, nanos, joint_state(head(nanos - 1_000, "base", i), names, *values)
        if i % 2 == 0:
            move = transform(vector(0.1 * i, -0.25, 1e-300), quaternion(0.0, 0.0, 0.6, 0.8))
            yield "/tf", tf, nanos + 7, tf([stamped(head(nanos, "world", i), "hand" * (i + 1), move)])
        if i % 3 == 0:
            yield "/ready", flag, nanos + 11, flag(i % 2 == 1)
            yield "/state", text, nanos + 11, text(["idle", "serve ä", "", "release"][i // 3])
        if i % 4 == 1:
            ranges = np.array([0.5 * k + i for k in range(40 * i)], dtype=np.float32)
            # As they are stored, in 32 bits.
            limits = (float(np.float32(limit)) for limit in (-1.5, 1.5, 0.1, 0.0, 0.05, 0.1, 30.0))
            yield "/scan", scan, nanos + 13, scan(head(nanos, "laser", i), *limits, ranges, ranges[:0])


def flatten(path, value):
    """(path, text) for each number and text."""
    if isinstance(value, (bool, np.bool_)):
        yield path, str(bool(value)).lower()
    elif isinstance(value, (int, float, np.number)):
        yield path, repr(value.item() if isinstance(value, np.number) else value)
    elif isinstance(value, str):
        yield path, '"' + value + '"'
    elif isinstance(value, (list, np.ndarray)):
        yield f"length({path})", str(len(value))
        for index, element in enumerate(value):
            yield from flatten(f"{path}[{index}]", element)
    else:
        for name in value.__dataclass_fields__:
            if not name.startswith("__"):
                yield from flatten(f"{path}.{name}" if path else name, getattr(value, name))


def write_ros1(name, compression, key=None):
    """`key` puts the messages into another order than that of time."""
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    writer = Writer1(FOLDER / name)
    if compression:
        writer.set_compression(compression)
    writer.chunk_threshold = 1500
    connections = {}
    with writer:
        for topic, kind, nanos, message in sorted(messages(store, True), key=key or (lambda row: row[2])):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind.__msgtype__, typestore=store)
            data = store.serialize_ros1(message, kind.__msgtype__)
            writer.write(connections[topic], nanos, data)


def write_ros2(name, storage, mode, keep=lambda nanos: True):
    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = Writer2(FOLDER / name, version=9, storage_plugin=storage)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    connections = {}
    with writer:
        for topic, kind, nanos, message in messages(store, False):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind.__msgtype__, typestore=store)
            if keep(nanos):
                writer.write(connections[topic], nanos, store.serialize_cdr(message, kind.__msgtype__))


def write_expected():
    store = get_typestore(Stores.ROS2_HUMBLE)
    with open(FOLDER / "expected.csv", "w") as out:
        for topic, _, nanos, message in messages(store, False):
            for path, value in flatten("", message):
                out.write(f"{topic},{nanos},{path},{value}\n")


def unfinish(name, source):
    """A bag as a recorder leaves it that was killed: no index, and the header not filled in."""
    data = bytearray((FOLDER / source).read_bytes())
    place = data.index(b"index_pos=") + len(b"index_pos=")
    index_at = int.from_bytes(data[place : place + 8], "little")
    data[place : place + 8] = bytes(8)
    for field in (b"conn_count=", b"chunk_count="):
        place = data.index(field) + len(field)
        data[place : place + 4] = bytes(4)
    (FOLDER / name).write_bytes(data[:index_at])


def split(name):
    """Two files of which the metadata name the later one last, as a recorder that splits writes them."""
    middle = START_NANOS + 600_000_000
    write_ros2("first", StoragePlugin.SQLITE3, CompressionMode.NONE, lambda nanos: nanos < middle)
    write_ros2("second", StoragePlugin.SQLITE3, CompressionMode.NONE, lambda nanos: nanos >= middle)
    folder = FOLDER / name
    folder.mkdir()
    (FOLDER / "first/first.db3").rename(folder / "z_0.db3")
    (FOLDER / "second/second.db3").rename(folder / "a_1.db3")
    yaml = YAML(typ="safe")
    yaml.default_flow_style = False
    whole = yaml.load(FOLDER / "first/metadata.yaml")
    parts = [whole, yaml.load(FOLDER / "second/metadata.yaml")]
    parts = [part["rosbag2_bagfile_information"] for part in parts]
    files = ["z_0.db3", "a_1.db3"]
    parts[0]["files"] = [part["files"][0] | {"path": file} for part, file in zip(parts, files)]
    parts[0]["relative_file_paths"] = files
    parts[0]["message_count"] = sum(part["message_count"] for part in parts)
    counts = [{t["topic_metadata"]["name"]: t["message_count"] for t in p["topics_with_message_count"]} for p in parts]
    for topic in parts[0]["topics_with_message_count"]:
        topic["message_count"] = sum(count[topic["topic_metadata"]["name"]] for count in counts)
    yaml.dump(whole, folder / "metadata.yaml")
    shutil.rmtree(FOLDER / "first")
    shutil.rmtree(FOLDER / "second")


def age(name, source):
    """The database of `source` as releases before Iron wrote it: no definitions of types. Small pages."""
    shutil.copyfile(FOLDER / source, FOLDER / name)
    connection = sqlite3.connect(FOLDER / name)
    connection.execute("DROP TABLE message_definitions")
    connection.execute("ALTER TABLE topics DROP COLUMN type_description_hash")
    connection.execute("UPDATE schema SET schema_version = 3, ros_distro = 'humble'")
    connection.commit()
    connection.execute("PRAGMA page_size = 512")
    connection.execute("VACUUM")
    connection.close()


def log_ahead(name, source):
    """The database of `source` as it is while it is recorded: the last rows are in the write-ahead log only.

    The log has other salts and checksums each time."""
    path = FOLDER / name
    shutil.copyfile(FOLDER / source, FOLDER / "live.db3")
    connection = sqlite3.connect(FOLDER / "live.db3", isolation_level=None)
    rows = connection.execute("SELECT * FROM messages ORDER BY id").fetchall()
    connection.execute("DELETE FROM messages WHERE id > 10")
    connection.execute("VACUUM")
    connection.execute("PRAGMA journal_mode = WAL")
    connection.execute("PRAGMA wal_autocheckpoint = 0")
    for row in rows[10:]:
        connection.execute("INSERT INTO messages VALUES(?, ?, ?, ?)", row)
    shutil.copyfile(FOLDER / "live.db3", path)
    shutil.copyfile(FOLDER / "live.db3-wal", FOLDER / (name + "-wal"))
    connection.close()
    (FOLDER / "live.db3").unlink()


shutil.rmtree(FOLDER, ignore_errors=True)
FOLDER.mkdir()
write_ros1("none.bag", None)
write_ros1("bz2.bag", Writer1.CompressionFormat.BZ2)
write_ros1("lz4.bag", Writer1.CompressionFormat.LZ4)
write_ros1("unordered.bag", None, lambda row: (row[2] // 100_000_000 * 7 % 5, row[2]))
unfinish("unfinished.bag", "lz4.bag")
write_ros2("sqlite", StoragePlugin.SQLITE3, CompressionMode.NONE)
write_ros2("sqlite_file", StoragePlugin.SQLITE3, CompressionMode.FILE)
write_ros2("sqlite_message", StoragePlugin.SQLITE3, CompressionMode.MESSAGE)
write_ros2("mcap", StoragePlugin.MCAP, CompressionMode.NONE)
write_ros2("mcap_message", StoragePlugin.MCAP, CompressionMode.MESSAGE)
write_ros2("mcap_file", StoragePlugin.MCAP, CompressionMode.FILE)
split("split")
age("humble.db3", "sqlite/sqlite.db3")
log_ahead("live_copy.db3", "humble.db3")
write_expected()
