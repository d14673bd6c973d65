"""The meridian of a body as a conforming planar subdivision.

Snapping, panels, fillets, outlines, and refusals of what does not fit together.
In: sections of a profile. Out: points, curves and faces that a mesher needs.
"""
