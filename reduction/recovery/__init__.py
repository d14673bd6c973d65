"""Displacement and stress of a solid from its reduced coordinates.

Fields, stress measures, and their completion in space.
In: reduced coordinates and the kept fields. Out: arrays on the mesh.
"""
