"""The corridor's program over the lock-step protocol, with ranges rounded to 32 bits as a LaserScan rounds them."""

import os
import struct
import sys
from dataclasses import replace

sys.path.insert(0, os.path.join(os.environ["CORRIDOR"], "controller"))
from corridor import Corridor  # noqa: E402
from corroborate_controller import Measurement, run  # noqa: E402


class Rounded(Corridor):
    def tick(self, inputs):
        sensors = dict(inputs.sensors)
        if scan := sensors.get("lidar"):
            ranges = [struct.unpack("f", struct.pack("f", r))[0] for r in scan.values["ranges"]]
            sensors["lidar"] = Measurement(scan.time_secs, {"ranges": ranges})
        return super().tick(replace(inputs, sensors=sensors))


if __name__ == "__main__":
    run(Rounded())
