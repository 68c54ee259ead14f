"""The command ``corroborate``, as the program has it: ``python -m corroborate``, or ``corroborate`` of the installed package."""

from __future__ import annotations

import os
import sys

from . import _engine
from ._surroundings import physics_library


def main() -> int:
    """Carries out the command of this process."""
    # The program reads its own environment: it is told where the package's physics library is.
    library = physics_library()
    if library is not None:
        os.environ.setdefault("CORROBORATE_MUJOCO", library)
    sys.stdout.flush()
    return _engine.command(["corroborate", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
