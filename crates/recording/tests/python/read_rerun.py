"""Lets Rerun convert a recording, and prints what it made of it."""

import os
import subprocess
import sys
import tempfile

rerun = os.path.join(os.path.dirname(sys.executable), "rerun")
with tempfile.TemporaryDirectory() as folder:
    converted = os.path.join(folder, "converted.rrd")
    command = [rerun, "mcap", "convert", sys.argv[1], "-o", converted]
    subprocess.run(command, check=True, capture_output=True)
    printed = subprocess.run([rerun, "rrd", "print", converted], check=True, capture_output=True)
print(printed.stdout.decode())
