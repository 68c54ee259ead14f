#!/usr/bin/env python3
"""A node as a team has it: drives straight on, and brakes when the laser sees something near. It knows nothing of its tests."""

import math
import time

import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty, EmptyResponse


class Stopper:
    """The speed falls from full at `slow_distance_m` to zero at `stop_distance_m` (ranges of the laser, m)."""

    def __init__(self):
        self.speed_m_s = rospy.get_param("~speed_m_s", 0.8)
        self.command = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
        self.reset(None)
        rospy.Service("~reset", Empty, self.reset)
        rospy.Subscriber("/scan", LaserScan, self.on_scan, queue_size=10, tcp_nodelay=True)

    def reset(self, _):
        """Reads the parameters again and forgets what was seen."""
        self.stop_distance_m = rospy.get_param("~stop_distance_m", 0.5)
        self.slow_distance_m = rospy.get_param("~slow_distance_m", 1.2)
        self.think_secs = rospy.get_param("~think_secs", 0.0)
        return EmptyResponse()

    def on_scan(self, scan):
        """One command for each scan."""
        time.sleep(self.think_secs)
        nearest = min([one for one in scan.ranges if scan.range_min <= one <= scan.range_max], default=math.inf)
        share = (nearest - self.stop_distance_m) / (self.slow_distance_m - self.stop_distance_m)
        command = Twist()
        command.linear.x = self.speed_m_s * min(1.0, max(0.0, share))
        self.command.publish(command)


if __name__ == "__main__":
    rospy.init_node("stopper")
    stopper = Stopper()
    rospy.spin()
