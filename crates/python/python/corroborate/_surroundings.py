"""What the engine is told of its surroundings: it reads no environment itself."""

from __future__ import annotations

import importlib.util
import os
import pathlib
import tempfile
from typing import Any, Union

__all__ = ["physics_library", "surroundings"]


def physics_library() -> Union[str, None]:
    """The physics library: as ``CORROBORATE_MUJOCO`` names it (set to nothing, there is none), else that of the installed package
    ``mujoco`` (``pip install corroborate[simulation]``)."""
    named = os.environ.get("CORROBORATE_MUJOCO")
    if named is not None:
        return named or None
    # Found without importing the package.
    package = importlib.util.find_spec("mujoco")
    for folder in (package.submodule_search_locations or []) if package else []:
        found = sorted(pathlib.Path(folder).glob("libmujoco.so.*"))
        if found:
            return str(found[-1])
    return None


def surroundings(*, trust: bool = False) -> dict[str, Any]:
    """For the engine's host. ``trust``: whether programs that the study names may run, whatever was allowed before."""
    clients, own = os.environ.get("CORROBORATE_CLIENTS"), os.environ.get("PYTHONPATH", "")
    path = None if clients is None else os.pathsep.join(filter(None, [os.path.join(clients, "python"), own]))
    return {"physics_library": physics_library(), "python_path": path, "scratch": tempfile.gettempdir(), "trust": trust}
