"""MuJoCo's own Python as a world of things from URDF: rigid bodies under gravity, driven joints, contacts that can be asked.

Units are SI; the world's frame has z upwards and its floor at z = 0. MuJoCo has of two surfaces the greater friction, and its
contacts are soft: as a spring and a damper that give way within about 20 ms.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

import mujoco
import numpy

# An URDF without this is merged into its parent where a joint is fixed, and loses what only shows it.
COMPILER = '<mujoco><compiler fusestatic="false" discardvisual="true" strippath="false"/></mujoco></robot>'


class World:
    """A physics of its own, which is built at the first step: what it holds is added before."""

    name = f"MuJoCo {mujoco.__version__}"

    def __init__(self, time_step_secs: float, floor_friction: float, gravity_m_s2: float = 9.81):
        self.time_step_secs = time_step_secs
        self.spec = mujoco.MjSpec()
        self.spec.option.timestep = time_step_secs
        self.spec.option.gravity = [0, 0, -gravity_m_s2]
        self.spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        self.spec.option.impratio = 10
        floor = self.spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1])
        floor.friction[0] = floor_friction
        self.roots: Dict[str, str] = {}
        self.forces: Dict[str, float] = {}
        self.built: Optional[Tuple[mujoco.MjModel, mujoco.MjData]] = None

    @staticmethod
    def surface_for(pair_friction: float) -> float:
        """The friction that two surfaces need so that both together have this one."""
        return pair_friction

    def add(self, name: str, description: Path, position_m: Sequence[float], fixed: bool, friction: float) -> None:
        """A thing from a URDF, its root's frame at a position."""
        text = description.read_text(encoding="utf-8").replace("</robot>", COMPILER)
        thing = mujoco.MjSpec.from_string(text)
        for geom in thing.geoms:
            geom.friction[0] = friction
        root = thing.worldbody.first_body()
        if not fixed:
            root.add_freejoint()
        frame = self.spec.worldbody.add_frame(pos=list(position_m))
        frame.attach_body(root, f"{name}/", "")
        self.roots[name] = f"{name}/{root.name.removeprefix(name + '/')}"

    def _built(self) -> Tuple[mujoco.MjModel, mujoco.MjData]:
        if self.built is None:
            model = self.spec.compile()
            self.built = model, mujoco.MjData(model)
            mujoco.mj_forward(*self.built)
        return self.built

    def push(self, name: str, joint: str, newtons: float) -> None:
        """The force (N or Nm) of a joint's drive, until another is given."""
        self.forces[f"{name}/{joint}"] = newtons

    def step(self) -> None:
        """One time step."""
        model, data = self._built()
        for joint, newtons in self.forces.items():
            data.qfrc_applied[model.joint(joint).dofadr[0]] = newtons
        mujoco.mj_step(model, data)

    def joint(self, name: str, joint: str) -> Tuple[float, float]:
        """A joint's position and velocity."""
        _, data = self._built()
        found = data.joint(f"{name}/{joint}")
        return float(found.qpos[0]), float(found.qvel[0])

    def position(self, name: str) -> Sequence[float]:
        """Where the root's frame of a thing is."""
        _, data = self._built()
        return [float(x) for x in data.body(self.roots[name]).xpos]

    def speed(self, name: str) -> float:
        """The magnitude of the velocity of a thing's root."""
        model, data = self._built()
        velocity = numpy.zeros(6)
        body = model.body(self.roots[name]).id
        mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
        return math.hypot(*(float(v) for v in velocity[3:]))

    def normal_force(self, name: str, other: str) -> float:
        """The sum of normal forces between two things in the last time step, in newtons."""
        model, data = self._built()
        things = {self._thing(model, name): 0, self._thing(model, other): 1}
        total = 0.0
        for index in range(data.ncon):
            contact = data.contact[index]
            of: List[Optional[int]] = [things.get(int(model.body_rootid[model.geom_bodyid[g]])) for g in contact.geom]
            if None not in of and of[0] != of[1]:
                force = numpy.zeros(6)
                mujoco.mj_contactForce(model, data, index, force)
                total += float(force[0])
        return total

    def _thing(self, model: mujoco.MjModel, name: str) -> int:
        return int(model.body(self.roots[name]).id)

    def close(self) -> None:
        """Frees it."""
        self.built = None
