"""Drake as a world of things from URDF: rigid bodies under gravity, joints driven by forces, contacts that can be asked.

Units are SI; the world's frame has z upwards and its floor at z = 0. Drake has of two surfaces' frictions m and n the harmonic mean,
2mn/(m+n), and its contacts here are points solved by SAP, nearly rigid.
"""

from __future__ import annotations

import logging
import math
from pathlib import Path
from typing import Dict, List, Optional, Sequence, Tuple

import numpy
from pydrake.geometry import AddRigidHydroelasticProperties, HalfSpace, ProximityProperties, RoleAssign, SceneGraphConfig
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction, DiscreteContactApproximation
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

# It warns of soft bodies, of which there are none here.
logging.getLogger("drake").setLevel(logging.ERROR)


class World:
    """A physics of its own, which is built at the first step: what it holds is added before."""

    name = "Drake"

    def __init__(self, time_step_secs: float, floor_friction: float, gravity_m_s2: float = 9.81):
        self.time_step_secs = time_step_secs
        self.builder = DiagramBuilder()
        self.plant, self.graph = AddMultibodyPlantSceneGraph(self.builder, time_step_secs)
        self.plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
        # Bodies touch over an area. As points, of which a pair of shapes has one, a box on a table rocks and slides too far.
        self.plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
        config = SceneGraphConfig()
        config.default_proximity_properties.compliance_type = "compliant"
        config.default_proximity_properties.hydroelastic_modulus = 1e7
        self.graph.set_config(config)
        self.plant.mutable_gravity_field().set_gravity_vector([0, 0, -gravity_m_s2])
        floor = ProximityProperties()
        floor.AddProperty("material", "coulomb_friction", CoulombFriction(floor_friction, floor_friction))
        AddRigidHydroelasticProperties(floor)
        self.plant.RegisterCollisionGeometry(self.plant.world_body(), RigidTransform(), HalfSpace(), "floor", floor)
        self.instances: Dict[str, ModelInstanceIndex] = {}
        self.places: Dict[str, Sequence[float]] = {}
        self.forces: Dict[Tuple[str, str], float] = {}
        self.simulator: Optional[Simulator] = None
        self.steps = 0

    @staticmethod
    def surface_for(pair_friction: float) -> float:
        """The friction that two surfaces need so that both together have this one."""
        return pair_friction

    def add(self, name: str, description: Path, position_m: Sequence[float], fixed: bool, friction: float) -> None:
        """A thing from a URDF, its root's frame at a position."""
        parser = Parser(self.plant)
        parser.SetAutoRenaming(True)
        (instance,) = parser.AddModels(str(description))
        self.instances[name] = instance
        root = self._root(name)
        if fixed:
            self.plant.WeldFrames(self.plant.world_frame(), root.body_frame(), RigidTransform(list(position_m)))
        else:
            self.places[name] = position_m
        for body in self.plant.GetBodyIndices(instance):
            for shape in self.plant.GetCollisionGeometriesForBody(self.plant.get_body(body)):
                self._surface(shape, friction)

    def _surface(self, shape, friction: float) -> None:
        properties = ProximityProperties(self.graph.model_inspector().GetProximityProperties(shape))
        properties.UpdateProperty("material", "coulomb_friction", CoulombFriction(friction, friction))
        self.graph.AssignRole(self.plant.get_source_id(), shape, properties, RoleAssign.kReplace)

    def _root(self, name: str):
        return self.plant.get_body(self.plant.GetBodyIndices(self.instances[name])[0])

    def _built(self) -> Simulator:
        if self.simulator is None:
            for name, instance in self.instances.items():
                for index in self.plant.GetJointIndices(instance):
                    joint = self.plant.get_joint(index)
                    if joint.num_velocities() == 1:
                        self.plant.AddJointActuator(f"{name}/{joint.name()}", joint)
            self.plant.Finalize()
            self.simulator = Simulator(self.builder.Build())
            for name, position in self.places.items():
                self.plant.SetFreeBodyPose(self._context(), self._root(name), RigidTransform(list(position)))
        return self.simulator

    def _context(self):
        return self.plant.GetMyMutableContextFromRoot(self._built().get_mutable_context())

    def push(self, name: str, joint: str, newtons: float) -> None:
        """The force (N or Nm) of a joint's drive, until another is given."""
        self.forces[name, joint] = newtons

    def _actuators(self, name: str) -> List[str]:
        indices = self.plant.GetJointActuatorIndices(self.instances[name])
        return [self.plant.get_joint_actuator(index).name() for index in indices]

    def step(self) -> None:
        """One time step."""
        context = self._context()
        by_instance: Dict[ModelInstanceIndex, numpy.ndarray] = {}
        for (name, joint), newtons in self.forces.items():
            instance = self.instances[name]
            count = self.plant.num_actuated_dofs(instance)
            place = self._actuators(name).index(f"{name}/{joint}")
            by_instance.setdefault(instance, numpy.zeros(count))[place] = newtons
        for instance, forces in by_instance.items():
            self.plant.get_actuation_input_port(instance).FixValue(context, forces)
        self.steps += 1
        self._built().AdvanceTo(self.steps * self.time_step_secs)

    def joint(self, name: str, joint: str) -> Tuple[float, float]:
        """A joint's position and velocity."""
        context, found = self._context(), self.plant.GetJointByName(joint, self.instances[name])
        return float(found.GetOnePosition(context)), float(found.GetOneVelocity(context))

    def position(self, name: str) -> Sequence[float]:
        """Where the root's frame of a thing is."""
        return [float(x) for x in self._root(name).EvalPoseInWorld(self._context()).translation()]

    def speed(self, name: str) -> float:
        """The magnitude of the velocity of a thing's root."""
        velocity = self._root(name).EvalSpatialVelocityInWorld(self._context()).translational()
        return math.hypot(*(float(v) for v in velocity))

    def normal_force(self, name: str, other: str) -> float:
        """The sum of normal forces between two things in the last time step, in newtons."""
        pair = {self.instances[name], self.instances[other]}
        results = self.plant.get_contact_results_output_port().Eval(self._context())
        total = 0.0
        for index in range(results.num_point_pair_contacts()):
            contact = results.point_pair_contact_info(index)
            bodies = (contact.bodyA_index(), contact.bodyB_index())
            if {self.plant.get_body(body).model_instance() for body in bodies} == pair:
                total += abs(float(contact.contact_force() @ contact.point_pair().nhat_BA_W))
        inspector = self.graph.model_inspector()
        for index in range(results.num_hydroelastic_contacts()):
            contact = results.hydroelastic_contact_info(index)
            surface = contact.contact_surface()
            frames = [inspector.GetFrameId(shape) for shape in (surface.id_M(), surface.id_N())]
            of = {self.plant.GetBodyFromFrameId(frame).model_instance() for frame in frames}
            if of == pair:
                mesh = surface.tri_mesh_W() if surface.is_triangle() else surface.poly_mesh_W()
                # At the edges of boxes the area is bent; as a whole it faces this way.
                facing = sum(mesh.area(face) * mesh.face_normal(face) for face in range(mesh.num_elements()))
                facing /= numpy.linalg.norm(facing)
                total += abs(float(contact.F_Ac_W().translational() @ facing))
        return total

    def close(self) -> None:
        """Frees it."""
        self.simulator = None
