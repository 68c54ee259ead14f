"""PyBullet as a world of things from URDF: rigid bodies under gravity, joints driven by forces, contacts that can be asked.

Units are SI; the world's frame has z upwards and its floor at z = 0. Bullet has of two surfaces the product of their frictions,
and its contacts are hard: an impact is over in one time step.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Dict, Sequence, Tuple

import pybullet


class World:
    """A physics of its own; `close` frees it."""

    name = f"PyBullet {pybullet.getAPIVersion()}"

    def __init__(self, time_step_secs: float, floor_friction: float, gravity_m_s2: float = 9.81):
        self.time_step_secs = time_step_secs
        self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0, 0, -gravity_m_s2, physicsClientId=self.client)
        # The same order of contacts in every run, whatever ran before in this process.
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=time_step_secs, numSubSteps=1, deterministicOverlappingPairs=1, physicsClientId=self.client
        )
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self.client)
        floor = pybullet.createMultiBody(0, plane, physicsClientId=self.client)
        self.bodies: Dict[str, int] = {"floor": floor}
        self.forces: Dict[Tuple[str, str], float] = {}
        self._surface(floor, floor_friction)

    @staticmethod
    def surface_for(pair_friction: float) -> float:
        """The friction that two surfaces need so that both together have this one."""
        return math.sqrt(pair_friction)

    def add(self, name: str, description: Path, position_m: Sequence[float], fixed: bool, friction: float) -> None:
        """A thing from a URDF, its root's frame at a position."""
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        body = pybullet.loadURDF(
            str(description), position_m, useFixedBase=fixed, flags=flags, physicsClientId=self.client
        )
        self.bodies[name] = body
        self._surface(body, friction)

    def _surface(self, body: int, friction: float) -> None:
        for link in range(-1, pybullet.getNumJoints(body, physicsClientId=self.client)):
            # Bullet takes 4 % of a body's velocity away each second unless it is told not to.
            pybullet.changeDynamics(
                body, link, lateralFriction=friction, linearDamping=0, angularDamping=0, physicsClientId=self.client
            )
            if link >= 0:
                # Each joint has a motor that holds it, until that is switched off.
                pybullet.setJointMotorControl2(
                    body, link, pybullet.VELOCITY_CONTROL, force=0, physicsClientId=self.client
                )

    def _joint(self, name: str, joint: str) -> Tuple[int, int]:
        body = self.bodies[name]
        for index in range(pybullet.getNumJoints(body, physicsClientId=self.client)):
            if pybullet.getJointInfo(body, index, physicsClientId=self.client)[1].decode() == joint:
                return body, index
        raise KeyError(f"{name} has no joint `{joint}`")

    def push(self, name: str, joint: str, newtons: float) -> None:
        """The force (N or Nm) of a joint's drive, until another is given."""
        self.forces[name, joint] = newtons

    def step(self) -> None:
        """One time step."""
        for (name, joint), newtons in self.forces.items():
            body, index = self._joint(name, joint)
            pybullet.setJointMotorControl2(
                body, index, pybullet.TORQUE_CONTROL, force=newtons, physicsClientId=self.client
            )
        pybullet.stepSimulation(physicsClientId=self.client)

    def joint(self, name: str, joint: str) -> Tuple[float, float]:
        """A joint's position and velocity."""
        body, index = self._joint(name, joint)
        return pybullet.getJointState(body, index, physicsClientId=self.client)[:2]

    def position(self, name: str) -> Sequence[float]:
        """Where the root's frame of a thing is; the centre of its mass has to be there."""
        return pybullet.getBasePositionAndOrientation(self.bodies[name], physicsClientId=self.client)[0]

    def speed(self, name: str) -> float:
        """The magnitude of the velocity of a thing's root."""
        return math.hypot(*pybullet.getBaseVelocity(self.bodies[name], physicsClientId=self.client)[0])

    def normal_force(self, name: str, other: str) -> float:
        """The sum of normal forces between two things in the last time step, in newtons."""
        contacts = pybullet.getContactPoints(self.bodies[name], self.bodies[other], physicsClientId=self.client)
        return sum(contact[9] for contact in contacts)

    def close(self) -> None:
        """Frees it."""
        pybullet.disconnect(physicsClientId=self.client)
