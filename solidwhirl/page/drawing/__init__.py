"""The drawing of the engine on a page, to scale.

Silhouettes, symbols, labels, materials.
In: a scene and its bodies. Out: SVG.
"""
