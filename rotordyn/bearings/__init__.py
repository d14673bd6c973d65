"""Bearings from their physics: geometry, load and speed to stiffness, damping and force.

Rolling bearings, short films, squeeze films, magnetic bearings; tables over the speed.
In: dimensions, loads, speeds. Out: matrices on (ux, uy), forces on the rotor.

What depends on the frequency is a `DynamicStiffness`.
"""

from __future__ import annotations

from solidwhirl.rotordyn.bearings.dynamic import DynamicStiffness

__all__ = ["DynamicStiffness"]
