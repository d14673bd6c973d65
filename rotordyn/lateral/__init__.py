"""Lateral analysis of one shaft, as API 617 asks for it.

Static loads of journals, where unbalance belongs, cross-coupling up to the loss of stability.
In: `AssembledSystem`, a shaft, its journal bearings. Out: loads, unbalances, sweeps.
"""
