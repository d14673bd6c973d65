"""Sectors of bodies with blades, holes and slots.

The cut that makes a sector, the solids that features are, element sizes about them, the mesh.
In: a body with features. Out: second-order tetrahedra of one sector, or of half of it.
"""
