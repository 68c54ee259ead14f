"""A stand-in for Isaac Sim's Python interface as `isaac_world.py` uses it: the same names, parameters and order, made up physics.

As the real one it refuses modules before the application runs, gives nothing before `reset`, has one world in a process, forgets an
effort after a step, has quaternions with w first, and numbers of single precision. Things are sliders: a carriage of 2 kg on a
rail along x with the joint `slide` (and a lock without effect, `latch`, before it), or blocks that fly.
"""

from __future__ import annotations

import importlib.machinery
import sys
import types

import numpy

MASS_KG = 2.0


class Stage:
    """What was put on the stage, and what may be asked."""

    running, references, world = False, {}, None


class SimulationApp:
    """Takes the settings of its launch."""

    def __init__(self, launch_config=None):
        assert launch_config == {"headless": True} and not Stage.running
        Stage.running = True


class Scene:
    """The registry of a world."""

    def __init__(self):
        self.things, self.ground = {}, False

    def add(self, thing):
        """Registers a thing by its name and gives it back."""
        assert thing.name not in self.things
        self.things[thing.name] = thing
        return thing

    def add_default_ground_plane(self):
        """The floor."""
        self.ground = True


class World:
    """One for a process, until `clear_instance`."""

    def __init__(self, physics_dt=None, rendering_dt=None, stage_units_in_meters=None, backend="numpy", device=None):
        assert Stage.world is None, "a world is a singleton"
        assert (stage_units_in_meters, backend, device) == (1.0, "numpy", "cpu") and rendering_dt == physics_dt
        Stage.world, self.scene, self.physics_dt, self.playing = self, Scene(), physics_dt, False

    def reset(self, soft=False):
        """Begins; the state is that of the beginning."""
        self.playing = True
        for thing in self.scene.things.values():
            thing.begin()

    def step(self, render=True):
        """One step of physics; with rendering it might be several."""
        assert not render and self.playing
        for thing in self.scene.things.values():
            thing.advance(self.physics_dt)

    def stop(self):
        """Things cannot be asked any more."""
        self.playing = False

    @classmethod
    def clear_instance(cls):
        """Lets go of the one world."""
        Stage.world = None


class Thing:
    """A prim with a pose."""

    def __init__(self, prim_path, name="prim", position=None):
        assert any(prim_path.startswith(path) for path in Stage.references), "there is no such prim"
        self.prim_path, self.name, self.at, self.x_m = prim_path, name, position, None

    def begin(self):
        """At its place, at rest."""
        self.x_m, self.v_m_s, self.force_n = numpy.float32(0), numpy.float32(0), 0.0

    def advance(self, secs):
        """Semi-implicitly."""
        self.v_m_s = numpy.float32(self.v_m_s + self.force_n / MASS_KG * secs)
        self.x_m = numpy.float32(self.x_m + self.v_m_s * secs)
        self.force_n = 0.0

    def get_world_pose(self):
        """Position and orientation (w, x, y, z): turned by 90 degrees about z."""
        return numpy.array(self.at, numpy.float32) + [self.x_m, 0, 0], numpy.array([0.5**0.5, 0, 0, 0.5**0.5], numpy.float32)

    def get_linear_velocity(self):
        """In the world's frame."""
        return numpy.array([self.v_m_s, 0, 0], numpy.float32)


class SingleRigidPrim(Thing):
    """A block, which flies upwards at 3 m/s and along x at 4 m/s."""

    def get_linear_velocity(self):
        """In the world's frame."""
        return numpy.array([4, 0, 3], numpy.float32)


class SingleArticulation(Thing):
    """A slider."""

    @property
    def dof_names(self):
        """Known once physics runs."""
        return ["latch", "slide"] if self.x_m is not None else None

    def get_joint_positions(self):
        """In the order of `dof_names`."""
        return None if self.x_m is None else numpy.array([0, self.x_m], numpy.float32)

    def get_joint_velocities(self):
        """The same of velocities."""
        return None if self.x_m is None else numpy.array([0, self.v_m_s], numpy.float32)

    def apply_action(self, action):
        """Efforts of the joints with these indices."""
        for index, effort in zip(action.joint_indices, action.joint_efforts):
            self.force_n = float(effort) if index == 1 else self.force_n


class ArticulationAction:
    """What is asked of joints."""

    def __init__(self, joint_positions=None, joint_velocities=None, joint_efforts=None, joint_indices=None):
        assert joint_positions is None and joint_velocities is None and len(joint_efforts) == len(joint_indices)
        self.joint_efforts, self.joint_indices = joint_efforts, joint_indices


def add_reference_to_stage(usd_path, prim_path):
    """Puts a file on the stage."""
    Stage.references[prim_path] = usd_path


class _AfterStart:
    """Finds modules of the core only once the application runs."""

    def __init__(self, modules):
        self.modules = modules

    def find_spec(self, name, path=None, target=None):
        """As an extension is found that the application has loaded."""
        if name in self.modules and Stage.running:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec):
        """The one that is there."""
        return self.modules[spec.name]

    def exec_module(self, module):
        """Nothing is left to do."""


def install():
    """Puts the stand-in where Isaac Sim would be; gives what takes it out again."""
    contents = {
        "isaacsim.core": {}, "isaacsim.core.utils": {}, "isaacsim.core.api": {"World": World},
        "isaacsim.core.prims": {"SingleArticulation": SingleArticulation, "SingleRigidPrim": SingleRigidPrim},
        "isaacsim.core.utils.stage": {"add_reference_to_stage": add_reference_to_stage},
        "isaacsim.core.utils.types": {"ArticulationAction": ArticulationAction},
    }
    modules = {}
    for name, content in contents.items():
        modules[name] = types.ModuleType(name)
        modules[name].__path__ = []
        vars(modules[name]).update(content)
    top = types.ModuleType("isaacsim")
    top.__path__, top.SimulationApp = [], SimulationApp
    sys.modules["isaacsim"] = top
    finder = _AfterStart(modules)
    sys.meta_path.insert(0, finder)
    Stage.running, Stage.references, Stage.world = False, {}, None

    def uninstall():
        sys.meta_path.remove(finder)
        for name in ["isaacsim", *modules]:
            sys.modules.pop(name, None)

    return uninstall
