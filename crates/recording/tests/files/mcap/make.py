"""Writes the MCAP files of this folder, with libraries that are not ours:
pip install mcap mcap-ros2-support mcap-protobuf-support rosbags protobuf lz4 zstandard
Every value is a formula of the message's number i, which the tests compute too."""
import json
from pathlib import Path

from mcap.writer import CompressionType, Writer
from mcap_protobuf.writer import Writer as ProtobufWriter
from mcap_ros2.writer import Writer as Ros2Writer

HERE = Path(__file__).parent
RULE = "=" * 80
HEADER = f"{RULE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{RULE}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
JOINTS = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n" + HEADER
TF = ("geometry_msgs/TransformStamped[] transforms\n" + RULE + "\nMSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\n"
      "string child_frame_id\ngeometry_msgs/Transform transform\n" + RULE + "\nMSG: geometry_msgs/Transform\n"
      "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n" + RULE + "\nMSG: geometry_msgs/Vector3\n"
      "float64 x\nfloat64 y\nfloat64 z\n" + RULE + "\nMSG: geometry_msgs/Quaternion\nfloat64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n" + HEADER)
MIXED = "uint8 IDLE=0\nbool on\nint8 a\nuint64 big\nfloat32 f\nint16[3] three\nuint8[] raw\nstring<=9 word\nint64 last\n"
NAMES = ["shoulder", "elbow", "wrist"]


def header(i, frame):
    return {"stamp": {"sec": 1_700_000_000 + i, "nanosec": 1000 * i}, "frame_id": frame}


def ros2(path, compression, count=20, **options):
    with open(path, "wb") as out:
        writer = Ros2Writer(out, compression=compression, **options)
        joints = writer.register_msgdef("sensor_msgs/msg/JointState", JOINTS)
        tf = writer.register_msgdef("tf2_msgs/msg/TFMessage", TF)
        mixed = writer.register_msgdef("p/msg/Mixed", MIXED)
        for i in range(count):
            time = 1_000_000 * i
            writer.write_message("/joint_states", joints, {
                "header": header(i, "base" + "x" * (i % 5)), "name": NAMES[:3 if i % 4 else 2],
                "position": [i + 0.25 * k for k in range(3)], "velocity": [-0.5 * i] * (i % 3), "effort": []}, time, time)
            transform = lambda k: {"translation": {"x": i + k, "y": 2.0, "z": 3.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
            writer.write_message("/tf", tf, {"transforms": [
                {"header": header(i, "base"), "child_frame_id": "hand" if k == i % 3 else f"link{k}", "transform": transform(k)}
                for k in range(3)]}, time + 1, time)
            writer.write_message("/mixed", mixed, {
                "on": i % 2 == 1, "a": -i, "big": 2**53 + 2 * i, "f": 0.5 * i, "three": [i, -i, 7], "raw": bytes(range(i % 7)),
                "word": "abcdefghi"[: i % 10], "last": -(10**9) * i}, time + 2, time)
        writer.finish()


def json_file(path):
    with open(path, "wb") as out:
        writer = Writer(out, compression=CompressionType.NONE, use_chunking=False, enable_data_crcs=True)
        writer.start()
        schema = writer.register_schema("Robot", "jsonschema", json.dumps({"type": "object"}).encode())
        with_schema = writer.register_channel("/robot", "json", schema)
        without = writer.register_channel("/bare", "json", 0)
        strange = writer.register_channel("/strange", "cbor", 0)
        for i in range(10):
            data = {"state": "carry" if i < 5 else "release", "hand": {"x": 0.1 * i}, "v": [i, i + 1],
                    "name": NAMES, "position": [i, 2 * i, 3 * i], "ok": i % 2 == 0, "gone": None}
            writer.add_message(with_schema, 1000 * i, json.dumps(data).encode(), 1000 * i)
            writer.add_message(without, 1000 * i + 1, json.dumps({"n": i}).encode(), 1000 * i)
            writer.add_message(strange, 1000 * i + 2, b"\xa0", 1000 * i)
        writer.add_metadata("run", {"seed": "7"})
        writer.finish()


def protobuf_file(path):
    from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
    file = descriptor_pb2.FileDescriptorProto(name="t.proto", package="t", syntax="proto3")
    mode = file.enum_type.add(name="Mode")
    for number, name in enumerate(["IDLE", "MOVING"]):
        mode.value.add(name=name, number=number)
    vector = file.message_type.add(name="Vector")
    kinds = descriptor_pb2.FieldDescriptorProto
    vector.field.add(name="x", number=1, type=kinds.TYPE_DOUBLE, label=1)
    vector.field.add(name="id", number=2, type=kinds.TYPE_STRING, label=1)
    state = file.message_type.add(name="State")
    state.oneof_decl.add(name="_maybe")
    for number, (name, kind, label) in enumerate([
            ("count", kinds.TYPE_SINT64, 1), ("on", kinds.TYPE_BOOL, 1), ("speed", kinds.TYPE_FLOAT, 1), ("mode", kinds.TYPE_ENUM, 1),
            ("hand", kinds.TYPE_MESSAGE, 1), ("points", kinds.TYPE_MESSAGE, 3), ("values", kinds.TYPE_INT32, 3),
            ("names", kinds.TYPE_STRING, 3), ("big", kinds.TYPE_FIXED64, 1), ("maybe", kinds.TYPE_INT32, 1)], 1):
        field = state.field.add(name=name, number=number, type=kind, label=label)
        if kind == kinds.TYPE_MESSAGE:
            field.type_name = ".t.Vector"
        if kind == kinds.TYPE_ENUM:
            field.type_name = ".t.Mode"
        if name == "maybe":
            field.oneof_index, field.proto3_optional = 0, True
    pool = descriptor_pool.DescriptorPool()
    pool.Add(file)
    State = message_factory.GetMessageClass(pool.FindMessageTypeByName("t.State"))
    with open(path, "wb") as out:
        with ProtobufWriter(out) as writer:
            for i in range(10):
                message = State(count=-i, on=i % 2 == 1, speed=0.5 * i, mode=i % 2, values=[i, -i, 300 * i], names=NAMES, big=2**60 + i)
                if i % 3:
                    message.hand.x = 1.5 * i
                    message.maybe = i - 1
                for k in range(i % 4):
                    message.points.add(x=10.0 * i + k, id=f"p{k}")
                writer.write_message("/state", message, log_time=1000 * i, publish_time=1000 * i)


def overlapping(path):
    """Chunks whose times overlap: two topics, each with chunks of its own, and messages out of order in them."""
    with open(path, "wb") as out:
        writer = Writer(out, chunk_size=1, compression=CompressionType.LZ4)
        writer.start()
        one = writer.register_channel("/one", "json", 0)
        two = writer.register_channel("/two", "json", 0)
        for i in [0, 5, 2, 9, 7, 3, 1, 8, 4, 6]:
            writer.add_message(one, 100 * i, json.dumps({"n": i}).encode(), 0)
            writer.add_message(two, 100 * i + 450, json.dumps({"n": -i}).encode(), 0)
        writer.finish()


def rosbags_file(path):
    """Written by `rosbags`, as ROS 2 records."""
    import shutil, tempfile
    import numpy
    from rosbags.rosbag2 import StoragePlugin, Writer as BagWriter
    from rosbags.typesys import Stores, get_typestore
    store = get_typestore(Stores.ROS2_HUMBLE)
    types = store.types
    with tempfile.TemporaryDirectory() as folder:
        bag = Path(folder) / "bag"
        with BagWriter(bag, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            imu = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
            for i in range(10):
                stamp = types["builtin_interfaces/msg/Time"](sec=i, nanosec=5)
                quaternion = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
                vector = types["geometry_msgs/msg/Vector3"]
                covariance = numpy.arange(9, dtype=float) + i
                message = types["sensor_msgs/msg/Imu"](
                    types["std_msgs/msg/Header"](stamp, "imu" * (i % 3)), quaternion, covariance, vector(0.0, 0.0, 0.1 * i),
                    covariance, vector(1.0, 2.0, 9.81), covariance)
                writer.write(imu, 1000 * i, store.serialize_cdr(message, message.__msgtype__))
        shutil.copy(next(bag.glob("*.mcap")), path)


ros2(HERE / "ros2_zstd.mcap", CompressionType.ZSTD, chunk_size=3000)
ros2(HERE / "ros2_lz4.mcap", CompressionType.LZ4, chunk_size=3000)
ros2(HERE / "ros2_plain.mcap", CompressionType.NONE, chunk_size=3000)
ros2(HERE / "ros2_small.mcap", CompressionType.ZSTD, count=4, chunk_size=700)
json_file(HERE / "json_unchunked.mcap")
protobuf_file(HERE / "protobuf.mcap")
overlapping(HERE / "overlapping.mcap")
rosbags_file(HERE / "rosbags.mcap")
