"""Meshes of parametric bodies by gmsh.

Meridians and solids, sizes from errors, quality, files.
In: a body of revolution. Out: second-order meshes.
"""
