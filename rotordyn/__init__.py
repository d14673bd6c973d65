"""Superelements of spinning bodies, their files, their assembly, and the analysis of an engine."""

from __future__ import annotations

from solidwhirl.rotordyn.beams import beam_superelement
from solidwhirl.rotordyn.bearing_laws import (
    LEE_ANISOTROPIC,
    LEE_ISOTROPIC,
    PolynomialLaw,
    SpeedLaw,
    TableLaw,
)
from solidwhirl.rotordyn.bearing_notes import BearingNote, bearing_notes
from solidwhirl.rotordyn.branch_notes import TrackingNote
from solidwhirl.rotordyn.campbell import Campbell, campbell
from solidwhirl.rotordyn.campbell_errors import CampbellErrors, campbell_errors
from solidwhirl.rotordyn.complex_form import ComplexForm, complex_form
from solidwhirl.rotordyn.critical_speed_errors import CriticalSpeedErrors, critical_speed_errors
from solidwhirl.rotordyn.critical_speeds import CriticalSpeed, critical_speeds
from solidwhirl.rotordyn.eigen import Modes, modes_at_speed
from solidwhirl.rotordyn.eigenvalue_errors import FrequencyErrors, frequency_errors
from solidwhirl.rotordyn.errors import AnalysisError, AssemblyError, SuperelementError
from solidwhirl.rotordyn.files import read_superelement, write_superelement
from solidwhirl.rotordyn.invariants import Invariant, check_superelement
from solidwhirl.rotordyn.parts import Bearing, End, Gear, InternalDamping, Rotor, System
from solidwhirl.rotordyn.pictures import draw_campbell
from solidwhirl.rotordyn.rigid_superelement import rigid_superelement
from solidwhirl.rotordyn.shafts import Disk
from solidwhirl.rotordyn.superelement import (
    Coordinate,
    ErrorForm,
    InterfaceNode,
    Superelement,
    attach_rigid_disk,
)
from solidwhirl.rotordyn.system import AssembledSystem, SpeedMatrices, assemble, matrices_at_speed
from solidwhirl.rotordyn.whirl import whirl_direction

__all__ = [
    "LEE_ANISOTROPIC",
    "LEE_ISOTROPIC",
    "AnalysisError",
    "AssembledSystem",
    "AssemblyError",
    "Bearing",
    "BearingNote",
    "Campbell",
    "CampbellErrors",
    "ComplexForm",
    "Coordinate",
    "CriticalSpeed",
    "CriticalSpeedErrors",
    "Disk",
    "End",
    "ErrorForm",
    "FrequencyErrors",
    "Gear",
    "InterfaceNode",
    "InternalDamping",
    "Invariant",
    "Modes",
    "PolynomialLaw",
    "Rotor",
    "SpeedLaw",
    "SpeedMatrices",
    "Superelement",
    "SuperelementError",
    "System",
    "TableLaw",
    "TrackingNote",
    "assemble",
    "attach_rigid_disk",
    "beam_superelement",
    "bearing_notes",
    "campbell",
    "campbell_errors",
    "check_superelement",
    "complex_form",
    "critical_speed_errors",
    "critical_speeds",
    "draw_campbell",
    "frequency_errors",
    "matrices_at_speed",
    "modes_at_speed",
    "read_superelement",
    "rigid_superelement",
    "whirl_direction",
    "write_superelement",
]
