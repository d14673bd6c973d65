"""Checks of results against the unsimplified system.

Residuals, counts of modes, responses and stability from the parts as they are given.
In: results and their system. Out: `Invariant` records, passed or not.
"""
