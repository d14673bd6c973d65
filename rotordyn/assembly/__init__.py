"""Rotors, bearings and gears as the matrices of one system.

Parts, speed laws of bearings, joints, internal damping, coordinates and reactions.
In: superelements and joints. Out: `AssembledSystem` and its matrices at a speed.
"""
