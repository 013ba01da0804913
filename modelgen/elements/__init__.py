"""The vocabulary: one physical thing per file. Importing this package makes every element known to model files."""

from modelgen.elements.applied_torque import HarmonicTorque, SteppedTorque
from modelgen.elements.brake import Brake
from modelgen.elements.gear_pair import GearPair
from modelgen.elements.ground import GroundDamper, GroundSpring
from modelgen.elements.inertia import Inertia
from modelgen.elements.rigid_gear import RigidGear
from modelgen.elements.shaft import Shaft
from modelgen.elements.stop import ElasticStop, HardStop

__all__ = [
    "Brake",
    "ElasticStop",
    "GearPair",
    "GroundDamper",
    "GroundSpring",
    "HardStop",
    "HarmonicTorque",
    "Inertia",
    "RigidGear",
    "Shaft",
    "SteppedTorque",
]
