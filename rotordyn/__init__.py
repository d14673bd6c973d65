"""Superelements of spinning bodies, their files, their assembly, and the analysis of an engine.

A name is imported when it is first asked for: who needs the errors waits for no analysis.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from solidwhirl.rotordyn.core.later import import_later

if TYPE_CHECKING:
    from solidwhirl.rotordyn.assembly.bearing_laws import (
        LEE_ANISOTROPIC,
        LEE_ISOTROPIC,
        PolynomialLaw,
        SpeedLaw,
        TableLaw,
    )
    from solidwhirl.rotordyn.assembly.bearing_notes import BearingNote, bearing_notes
    from solidwhirl.rotordyn.assembly.frequency_laws import (
        AnyFrequencyLaw,
        FrequencyLaw,
        FrequencyTableLaw,
    )
    from solidwhirl.rotordyn.assembly.parts import (
        Bearing,
        End,
        Gear,
        InternalDamping,
        Rotor,
        System,
    )
    from solidwhirl.rotordyn.assembly.system import (
        AssembledSystem,
        SpeedMatrices,
        assemble,
        matrices_at_speed,
    )
    from solidwhirl.rotordyn.beams.shafts import Disk
    from solidwhirl.rotordyn.beams.superelement import beam_superelement
    from solidwhirl.rotordyn.campbell.branches import TrackingNote
    from solidwhirl.rotordyn.campbell.diagram import Campbell, campbell
    from solidwhirl.rotordyn.core.errors import AnalysisError, AssemblyError, SuperelementError
    from solidwhirl.rotordyn.critical_speeds.search import CriticalSpeed, critical_speeds
    from solidwhirl.rotordyn.estimates.campbell_errors import CampbellErrors, campbell_errors
    from solidwhirl.rotordyn.estimates.critical_speed_errors import (
        CriticalSpeedErrors,
        critical_speed_errors,
    )
    from solidwhirl.rotordyn.estimates.eigenvalue_errors import FrequencyErrors, frequency_errors
    from solidwhirl.rotordyn.modes.complex_form import ComplexForm, complex_form
    from solidwhirl.rotordyn.modes.eigen import Modes, modes_at_speed
    from solidwhirl.rotordyn.modes.whirl import whirl_direction
    from solidwhirl.rotordyn.plots.campbell import draw_campbell
    from solidwhirl.rotordyn.storage.files import read_superelement, write_superelement
    from solidwhirl.rotordyn.superelement.invariants import Invariant, check_superelement
    from solidwhirl.rotordyn.superelement.record import (
        Coordinate,
        ErrorForm,
        InterfaceNode,
        Superelement,
    )
    from solidwhirl.rotordyn.superelement.rigid_body import attach_rigid_disk, rigid_superelement

__all__ = [
    "LEE_ANISOTROPIC",
    "LEE_ISOTROPIC",
    "AnalysisError",
    "AnyFrequencyLaw",
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
    "FrequencyLaw",
    "FrequencyTableLaw",
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

import_later(__name__)
