"""Matrices of other programs as superelements.

Rows, units, axes, rigid motions, and what must hold before a body may turn.
In: `ForeignBody` of `exchange.matrices`. Out: `Superelement`.
"""
