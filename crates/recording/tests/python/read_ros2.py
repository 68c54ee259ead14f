"""Reads a recording twice: by the schemas in it, and by the types that rosbags knows."""

import sys

from mcap.reader import make_reader
from mcap_ros2.reader import read_ros2_messages
from rosbags.typesys import Stores, get_typestore

path = sys.argv[1]
by_schema = list(read_ros2_messages(path))
store = get_typestore(Stores.ROS2_HUMBLE)
same = 0
with open(path, "rb") as file:
    for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
        known = store.deserialize_cdr(message.data, schema.name)
        again = bytes(store.serialize_cdr(known, schema.name))
        if again != message.data:
            sys.exit(f"{channel.topic}: {again.hex()} is not {message.data.hex()}")
        same += 1
if same != len(by_schema):
    sys.exit(f"{same} messages by one, {len(by_schema)} by the other")
print(f"{same} messages are the same")
for message in by_schema:
    topic, read = message.channel.topic, message.ros_msg
    if topic == "/filled":
        header = read.header
        print(
            f"{topic} sec={header.stamp.sec} nanosec={header.stamp.nanosec} "
            f"frame_id={header.frame_id} name={read.name} position={read.position} "
            f"effort={read.effort}"
        )
    if topic == "/state":
        print(topic, read.data)
