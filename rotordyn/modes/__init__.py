"""Modes of an assembled system at one speed.

Eigenvalues by the form that the structure allows, whirl, damping, shapes, participation.
In: `AssembledSystem` and a speed. Out: `Modes` and what is read from them.
"""
