"""Tooth geometry to mesh stiffness to Fourier rows: Eq. 1-11 of the paper as numbers, NumPy only.

    Gear, Gear, width -> GearMesh -> k_m over the base pitch -> FourierSeries (Eq. 9), StiffnessVariation
                                 \\-> TransmissionError under load, ISO 6336-1 method B beside it

``mesh_stiffness_rows`` goes all the way from plain numbers; model parameters derive from it.
"""

from modelgen.gears.damping import equivalent_mass, mesh_damping
from modelgen.gears.deflection import ToothDeflection, contact_deflection, tooth_deflection
from modelgen.gears.fourier import (
    FourierSeries,
    SeriesErrors,
    fit_series,
    mesh_stiffness_rows,
    mesh_stiffness_series,
    series_errors,
)
from modelgen.gears.geometry import Gear
from modelgen.gears.iso6336 import Iso6336Stiffness, gear_blank_factor, iso6336_stiffness
from modelgen.gears.mesh import GearMesh
from modelgen.gears.phase import mesh_phase, phase_between
from modelgen.gears.tooth import Tooth
from modelgen.gears.transmission_error import MeshError, TransmissionError, static_transmission_error
from modelgen.gears.variation import StiffnessVariation, stiffness_variation

__all__ = [
    "FourierSeries",
    "Gear",
    "GearMesh",
    "Iso6336Stiffness",
    "MeshError",
    "SeriesErrors",
    "StiffnessVariation",
    "Tooth",
    "ToothDeflection",
    "TransmissionError",
    "contact_deflection",
    "equivalent_mass",
    "fit_series",
    "gear_blank_factor",
    "iso6336_stiffness",
    "mesh_damping",
    "mesh_phase",
    "mesh_stiffness_rows",
    "mesh_stiffness_series",
    "phase_between",
    "series_errors",
    "static_transmission_error",
    "stiffness_variation",
    "tooth_deflection",
]
