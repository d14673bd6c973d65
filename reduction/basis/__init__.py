"""The Craig-Bampton basis of one circumferential order.

Constraint modes, fixed-interface modes at rest and at speed, pairs, rigid motions.
In: operators and solvers. Out: a basis that is valid over a range of speeds.
"""
