"""The scene of this study in a physics of others: `simulate.py PHYSICS [STIMULUS SEED RECORDING]`.

PHYSICS is `pybullet`, `drake` or `mujoco`: an adapter of `integrations/`. Without the other words episodes are asked for line by
line. Everything but the physics is the same for all: the descriptions in `scene/`, the program in `program/pusher.py`, the law of
the drive, time step, table. What varies is in the stimulus. The recording has the names and units of the tool's own scene.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
INTEGRATIONS = HERE.parent.parent / "integrations"
sys.path[:0] = [str(INTEGRATIONS / "common"), str(HERE / "program")]

from corroborate_rig import Episode, Recording, main  # noqa: E402
from pusher import Pusher  # noqa: E402

PHYSICS = ("pybullet", "drake", "mujoco")
SIGNALS = {
    "/truth/crate.x": "m",
    "/truth/crate.speed": "m/s",
    "/truth/crate.distance_to.hand": "m",
    "/truth/pusher.contact.crate.normal_force": "N",
    "/controller/program.released": "",
}
TIME_STEP_SECS = 0.001
TICK_STEPS = 10
ROW_STEPS = 10
DURATION_SECS = 2.0
DRIVE_GAIN_NS_M = 200.0
DRIVE_LIMIT_N = 80.0
HALF_M = 0.06
HAND_X_M = 0.74
HAND_HALF_M = 0.04
SETTINGS = {
    "release_m": 0.30,
    "mark_m": 0.56,
    "crate_half_m": HALF_M,
    "believed_friction": 0.25,
    "acceleration_m_s2": 3.0,
    "period_secs": TICK_STEPS * TIME_STEP_SECS,
}


def built(physics, episode: Episode):
    """The scene. `matched` gives both surfaces what makes the pair's friction that of the tool, the smaller of both; without it each
    surface has its own, and the physics makes of both what it does."""
    table, crate = episode.number("ground.friction"), episode.number("object.crate.friction")
    if episode.settings.get("matched", False):
        table = crate = physics.surface_for(min(table, crate))
    world = physics(TIME_STEP_SECS, table)
    world.add("pusher", HERE / "scene/pusher.urdf", [0, 0, 0], True, crate)
    world.add("crate", HERE / "scene/crate.urdf", [episode.number("object.crate.x_m"), 0, 0.04], False, crate)
    world.add("hand", HERE / "scene/hand.urdf", [HAND_X_M, 0, 0.02], True, crate)
    return world


def played(world) -> Recording:
    """The program in the scene, from beginning to end."""
    recording, program = Recording(SIGNALS), Pusher(SETTINGS)
    wanted_m_s, hardest_n = 0.0, 0.0
    for step in range(round(DURATION_SECS / TIME_STEP_SECS) + 1):
        position_m, velocity_m_s = world.joint("pusher", "slide")
        if step % TICK_STEPS == 0:
            wanted_m_s = program.velocity(position_m)
        if step % ROW_STEPS == 0:
            x = world.position("crate")[0]
            # Both are boxes along the axes; a crate that turns on its way touches earlier, by millimetres.
            gap = max(0.0, HAND_X_M - HAND_HALF_M - HALF_M - x)
            recording.row(step * TIME_STEP_SECS, x, world.speed("crate"), gap, hardest_n, program.released)
            hardest_n = 0.0
        newtons = DRIVE_GAIN_NS_M * (wanted_m_s - velocity_m_s)
        world.push("pusher", "slide", max(-DRIVE_LIMIT_N, min(DRIVE_LIMIT_N, newtons)))
        world.step()
        # Impacts are shorter than the time between rows.
        hardest_n = max(hardest_n, world.normal_force("pusher", "crate"))
    return recording


def physics_called(name: str):
    """The class `World` of an adapter."""
    if name not in PHYSICS:
        sys.exit(f"simulate.py: `{name}` is no physics; choose {', '.join(PHYSICS)}")
    sys.path.insert(0, str(INTEGRATIONS / name))
    return importlib.import_module(f"{name}_world").World


def runner(name: str):
    """What runs an episode in this physics."""
    physics = physics_called(name)

    def run(episode: Episode) -> Recording:
        world = built(physics, episode)
        try:
            return played(world)
        finally:
            world.close()

    return run


if __name__ == "__main__":
    arguments = sys.argv[1:]
    if not arguments:
        sys.exit(f"usage: simulate.py PHYSICS [STIMULUS SEED RECORDING], with a physics of {', '.join(PHYSICS)}")
    main(runner(arguments[0]), arguments[1:])
