"""Meshes and geometry of other programs as bodies.

gmsh, VTU, INP, Nastran and STEP, on the axis, in metres, checked.
In: a file and what a scene asks of it. Out: `MeshedBody` with its mesh.
"""
