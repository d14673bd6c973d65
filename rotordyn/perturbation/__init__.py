"""Modes of a system that is changed a little, from those that are known.

Left vectors, by which eigenvalues follow small changes of the matrices, and the lowest modes at
speeds near one whose whole spectrum is known.
In: `AssembledSystem` and `Modes` at a speed. Out: their left vectors, `Modes` at other speeds.
"""
