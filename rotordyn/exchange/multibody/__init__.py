"""Flexible bodies for multibody programs: SID, MBDyn.

The body in a frame that moves with it, its invariants, and points of equal mass.
In: `Superelement`. Out: input files.
"""
