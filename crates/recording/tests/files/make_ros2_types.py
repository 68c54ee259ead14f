"""Writes ros2_types.txt: the fields of the ROS 2 interface types that are the same in every release before
type definitions were stored in recordings (Dashing to Humble), as the `rosbags` package knows them.

It does not know control_msgs. Those lines are kept by hand: the types whose .msg files are the same on the
branches foxy-devel, galactic-devel and humble of ros-controls/control_msgs (JointTrajectoryControllerState is not)."""
import re, sys
from rosbags.typesys import Stores, get_typestore

STORES = [Stores.ROS2_DASHING, Stores.ROS2_ELOQUENT, Stores.ROS2_FOXY, Stores.ROS2_GALACTIC, Stores.ROS2_HUMBLE]
PACKAGES = ["action_msgs", "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rosgraph_msgs",
            "sensor_msgs", "std_msgs", "tf2_msgs", "trajectory_msgs", "unique_identifier_msgs"]


def fields(store, name):
    text, _ = store.generate_msgdef(name, ros_version=2)
    lines = [line.split("#")[0].strip() for line in text.split("=" * 80)[0].splitlines()]
    return tuple(line for line in lines if line and not re.match(r"^\S+\s+\w+\s*=", line))


found = {}
for store in map(get_typestore, STORES):
    for name in store.fielddefs:
        if name.split("/")[0] in PACKAGES and "/msg/" in name:
            found.setdefault(name, set()).add(fields(store, name))
same = {name: list(variants)[0] for name, variants in found.items() if len(variants) == 1}


def needs(line):
    base = re.split(r"[\[<]", line.split()[0])[0]
    return base.replace("/", "/msg/") if "/" in base else None


while missing := [n for n, f in same.items() if any(needs(l) and needs(l) not in same for l in f)]:
    for name in missing:
        print("left out:", name, file=sys.stderr)
        del same[name]
print("left out:", sorted(set(found) - set(same)), file=sys.stderr)
with open(sys.argv[1], "w") as out:
    for name in sorted(same):
        out.write(f"{name.replace('/msg/', '/')}: {'; '.join(same[name])}\n")
