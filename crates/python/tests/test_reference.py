"""The page of reference is what the docstrings say."""

import pathlib
import subprocess
import sys


def test_the_page_is_made_of_the_docstrings():
    script = pathlib.Path(__file__).parents[1] / "reference"
    done = subprocess.run([sys.executable, str(script), "--check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
