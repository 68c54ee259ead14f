"""Writes the scene: `python3 make_scene.py > scene.toml`. A robot is a dozen tables of the scene, so the scene is made, not typed."""

ROBOTS = 4
BAGS = 4

HEAD = """\
# Made by make_scene.py: change that one. A room of 4 m by 3 m; the counter is the strip along x = 0, the store is the far half.
# Four robots, four bags with a jacket each.
name = "cloakroom"

[simulation]
time_step_secs = 0.002
duration_secs = 90
record_hz = 10
longest_distance_m = 3

[ground]
friction = { uniform = [0.6, 0.9] }

[[region]]
name = "counter"
box_m = [0.7, 3.0, 1.0]
x_m = 0.35
y_m = 0.0
z_m = 0.5

[[abstract_test]]
name = "bring all"
actions = []
"""

WALL = """
[[object]]
name = "{name}_wall"
box_m = [{x_size}, {y_size}, 0.4]
x_m = {x}
y_m = {y}
z_m = 0.2
"""

BAG = """
# A bag with a jacket stands in the store, slides on the floor, and is held by a cup.
[[object]]
name = "bag{n}"
radius_m = 0.07
length_m = 0.12
mass_kg = {{ uniform = [0.25, 0.4] }}
friction = {{ uniform = [0.15, 0.25] }}
x_m = {{ uniform = [2.3, 3.75] }}
y_m = {{ uniform = [{low}, {high}] }}
z_m = 0.06
"""

ROBOT = """
[[robot]]
name = "r{n}"
file = "robot.urdf"
x_m = {{ uniform = [0.95, 1.25] }}
y_m = {{ uniform = [{low}, {high}] }}
yaw_rad = {{ uniform = [-1.5, 1.5] }}
friction = 0.7

[[tool_point]]
name = "mouth{n}"
robot = "r{n}"
x_m = 0.125
z_m = 0.06
pitch_rad = 1.5707963267948966

[[gripper]]
name = "cup{n}"
robot = "r{n}"
kind = "suction"
tool_point = "mouth{n}"
holding_force_newtons = {{ uniform = [8.0, 15.0] }}
reach_m = 0.02

[[actuator]]
name = "drive{n}"
robot = "r{n}"
kind = "differential_drive"
left_joints = ["left_wheel_joint"]
right_joints = ["right_wheel_joint"]
wheel_radius_m = 0.04
wheel_separation_m = 0.2
longest_speed_m_s = 0.5
longest_turn_rate_rad_s = 2.0
acceleration_m_s2 = 0.8
deceleration_m_s2 = 1.2
turn_acceleration_rad_s2 = 6.0
gain_nms_rad = 0.3
torque_limit_nm = 0.6

[[sensor]]
name = "lidar{n}"
robot = "r{n}"
kind = "lidar"
rate_hz = 10
latency_secs = {{ uniform = [0.01, 0.04] }}
noise = {{ ranges_m = 0.01 }}
z_m = 0.2
rays = 33
first_angle_rad = -2.0943951023931953
last_angle_rad = 2.0943951023931953
shortest_m = 0.13
longest_m = 1.5

[[sensor]]
name = "pose{n}"
robot = "r{n}"
kind = "pose"
rate_hz = 10
latency_secs = 0.02
noise = {{ x_m = 0.01, y_m = 0.01, yaw_rad = 0.01 }}

[[sensor]]
name = "grip{n}"
robot = "r{n}"
kind = "grip"
rate_hz = 10
gripper = "cup{n}"
"""

CAMERA = """
[[sensor]]
name = "camera{n}_{bag}"
robot = "r{n}"
kind = "marker_camera"
rate_hz = 5
target = "bag{bag}"
horizontal_view_rad = 2.0
vertical_view_rad = 2.6
longest_m = 1.0
detection_probability = 0.9
z_m = 0.2
"""

PROGRAM = """
[[controller]]
name = "p{n}"
robot = "r{n}"
command = ["python3", "../program/robot.py"]
files = ["../program/forager.py"]
period_secs = 0.1
latency_secs = 0.01

[controller.settings]
number = {n}
cruise_speed_m_s = 0.4
slow_speed_m_s = 0.15
turn_rate_rad_s = 1.8
body_radius_m = 0.125
way_half_width_m = 0.25
avoid_m = 0.4
stop_m = 0.15
drop_x_m = 0.45
store_from_x_m = 0.8
shortest_leg_secs = 2.0
longest_leg_secs = 6.0
approach_secs = 8.0
forget_secs = 1.5
back_off_secs = 1.5
"""


def strips(count):
    """A strip of the room's width for each, so that nothing begins in another."""
    width = 2.6 / count
    return [(round(-1.3 + width * k + 0.22, 3), round(-1.3 + width * (k + 1) - 0.22, 3)) for k in range(count)]


def main():
    print(HEAD, end="")
    for name, x, y, x_size, y_size in (
        ("counter", -0.05, 0.0, 0.1, 3.2),
        ("store", 4.05, 0.0, 0.1, 3.2),
        ("left", 2.0, 1.55, 4.0, 0.1),
        ("right", 2.0, -1.55, 4.0, 0.1),
    ):
        print(WALL.format(name=name, x=x, y=y, x_size=x_size, y_size=y_size), end="")
    for n, (low, high) in enumerate(strips(BAGS), 1):
        print(BAG.format(n=n, low=low, high=high), end="")
    for n, (low, high) in enumerate(strips(ROBOTS), 1):
        print(ROBOT.format(n=n, low=low, high=high), end="")
        for bag in range(1, BAGS + 1):
            print(CAMERA.format(n=n, bag=bag), end="")
        print(PROGRAM.format(n=n), end="")


if __name__ == "__main__":
    main()
