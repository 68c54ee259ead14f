"""Isaac Sim as a world of things from USD: joints driven by efforts, poses and speeds that can be asked. Isaac Lab's, too.

    world = World(time_step_secs=1 / 120)
    world.add("arm", "arm.usd", position_m=(0, 0, 0))
    world.reset()
    for step in range(600):
        world.push("arm", "joint_1", 0.5)
        world.step()
        angle_rad, rate_rad_s = world.joint("arm", "joint_1")

Written to the Python interface of Isaac Sim 4.5 and 5 (`isaacsim.core.api`). Run it with Isaac Sim's Python. With Isaac Lab give
`app=AppLauncher(headless=True).app`. Units are SI; the world's frame has z upwards; quaternions are x, y, z, w here and w, x, y, z there.
One process has one application and one world: `reset` begins an episode.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Dict, Optional, Sequence, Tuple, Union

_APP: Optional[Any] = None


def application(app: Optional[Any] = None) -> Any:
    """The one application of this process. Nothing else of Isaac Sim can be imported before it runs; its start takes a while."""
    global _APP
    if app is not None or _APP is None:
        if app is None:
            try:
                from isaacsim import SimulationApp
            except ImportError as error:
                raise RuntimeError(f"Isaac Sim cannot be imported ({error}); run this with its own Python") from error
            app = SimulationApp({"headless": True})
        _APP = app
    return _APP


class World:
    """Its physics; `close` frees it, and the application goes on for the next one."""

    name = "Isaac Sim"

    def __init__(self, time_step_secs: float, app: Optional[Any] = None):
        if time_step_secs <= 0:
            raise ValueError(f"`time_step_secs` must be positive (got {time_step_secs:g})")
        application(app)
        # They exist only now.
        from isaacsim.core.api import World as IsaacWorld

        self.time_step_secs = time_step_secs
        # On the processor, without rendering: on a graphics card sums have no fixed order.
        self.world = IsaacWorld(
            physics_dt=time_step_secs, rendering_dt=time_step_secs, stage_units_in_meters=1.0, backend="numpy", device="cpu"
        )
        self.world.scene.add_default_ground_plane()
        self.things: Dict[str, Any] = {}
        self.efforts: Dict[Tuple[str, str], float] = {}
        self.is_ready = False

    def add(
        self, name: str, description: Union[str, Path], position_m: Sequence[float], articulated: bool = True,
        root: str = "",
    ) -> None:
        """A thing from a USD file, at a position; `root` is the prim under it that is the articulation or the rigid body, if not itself."""
        from isaacsim.core.prims import SingleArticulation, SingleRigidPrim
        from isaacsim.core.utils.stage import add_reference_to_stage

        if name in self.things:
            raise ValueError(f"there is already a thing called `{name}`")
        if "://" not in str(description) and not Path(description).is_file():
            raise FileNotFoundError(f"the description {description} does not exist")
        path = f"/World/{name}"
        add_reference_to_stage(usd_path=str(description), prim_path=path)
        kind = SingleArticulation if articulated else SingleRigidPrim
        self.things[name] = self.world.scene.add(kind(prim_path=path + root, name=name, position=_array(position_m)))
        self.is_ready = False

    def reset(self) -> None:
        """To the beginning: things as they were added, at rest, without efforts. Needed once all are there, and for each episode."""
        self.efforts.clear()
        self.world.reset()
        self.is_ready = True

    def push(self, name: str, joint: str, effort: float) -> None:
        """The effort (N or Nm) of a joint's drive, until another is given. The joint's own drive must have no stiffness and damping."""
        self._index(name, joint)
        self.efforts[name, joint] = effort

    def step(self) -> None:
        """One time step of physics, without rendering."""
        from isaacsim.core.utils.types import ArticulationAction

        if not self.is_ready:
            raise RuntimeError("a world steps only after `reset`, which comes after all things were added")
        by_thing: Dict[str, Dict[int, float]] = {}
        for (name, joint), effort in self.efforts.items():
            by_thing.setdefault(name, {})[self._index(name, joint)] = effort
        # Efforts hold for one step.
        for name, efforts in by_thing.items():
            action = ArticulationAction(joint_efforts=_array(list(efforts.values())), joint_indices=_array(list(efforts), "int64"))
            self._thing(name).apply_action(action)
        self.world.step(render=False)

    def joint(self, name: str, joint: str) -> Tuple[float, float]:
        """A joint's position and velocity (rad and rad/s, or m and m/s)."""
        index, thing = self._index(name, joint), self._thing(name)
        return float(thing.get_joint_positions()[index]), float(thing.get_joint_velocities()[index])

    def position(self, name: str) -> Sequence[float]:
        """Where the root's frame of a thing is, in the world's."""
        return tuple(map(float, self._thing(name).get_world_pose()[0]))

    def orientation(self, name: str) -> Sequence[float]:
        """How the root's frame of a thing is turned in the world's: a quaternion x, y, z, w."""
        w, x, y, z = map(float, self._thing(name).get_world_pose()[1])
        return x, y, z, w

    def speed(self, name: str) -> float:
        """The magnitude of the velocity of a thing's root, in m/s."""
        return math.hypot(*map(float, self._thing(name).get_linear_velocity()))

    def close(self) -> None:
        """Frees the world."""
        self.world.stop()
        self.world.clear_instance()

    def _thing(self, name: str) -> Any:
        if name not in self.things:
            raise KeyError(f"there is no thing called `{name}`; there are {', '.join(self.things) or 'none'}")
        if not self.is_ready:
            raise RuntimeError("things can be asked only after `reset`, which comes after all were added")
        return self.things[name]

    def _index(self, name: str, joint: str) -> int:
        names = list(getattr(self._thing(name), "dof_names", None) or [])
        if joint not in names:
            raise KeyError(f"{name} has no joint `{joint}`; it has {', '.join(names) or 'none'}")
        return names.index(joint)


def _array(values: Sequence[float], kind: str = "float64") -> Any:
    import numpy  # Comes with Isaac Sim.

    return numpy.array(values, dtype=kind)
