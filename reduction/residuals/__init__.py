"""What a reduction leaves out.

Energy of truncated modes and of the mesh, as Gram matrices and per element.
In: operators and a basis. Out: error forms and indicators.
"""
