"""Python files that run in Exudyn and ROSS.

Each stands alone with its data beside it.
In: `Superelement`. Out: a script and an .npz file.
"""
