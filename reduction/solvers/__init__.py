"""Distributed linear algebra: systems and eigenproblems under constraints.

Factors, multigrid, SLEPc's shift-and-invert, block iterations, vectors and halo exchange.
In: PETSc matrices and constraints. Out: solutions, modes.
"""
