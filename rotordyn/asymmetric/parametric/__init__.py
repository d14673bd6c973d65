"""Parametric instability: growth that comes of matrices which change with the angle.

In: a periodic system. Out: its Floquet exponents and multipliers, motions by Hill's method,
unstable ranges of speed.
"""
