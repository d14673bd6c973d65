"""Bearings from their physics: geometry, load and speed to stiffness, damping and force.

Rolling bearings, short films, squeeze films, magnetic bearings; tables over the speed.
In: dimensions, loads, speeds. Out: matrices on (ux, uy), forces on the rotor.

What depends on the frequency has the method `dynamic_stiffness(speed_rad_s, eigenvalue)`: complex
Z, shape (2, 2), the force on the rotor being −Z u for a motion u e^(eigenvalue · t) on (ux, uy).
"""

from __future__ import annotations

from solidwhirl.rotordyn.bearings.dynamic import DynamicStiffness

__all__ = ["DynamicStiffness"]
