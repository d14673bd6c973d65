"""Stepped shafts as Timoshenko beams and rods.

Elements, shafts with disks, and their superelements.
In: sections, disks and materials. Out: `Superelement`.
"""

from __future__ import annotations

from solidwhirl.rotordyn.beams.superelement import Disk, beam_superelement

__all__ = ["Disk", "beam_superelement"]
