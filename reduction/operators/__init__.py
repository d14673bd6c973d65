"""Matrices of a spinning body on its mesh.

Weak forms, kinematics, coupling, prestress, symmetry; the differences between DOLFINx versions.
In: a mesh. Out: `BodyOperators`.
"""
