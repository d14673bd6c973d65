"""What the analysis of nodal diameters computes and tells.

In: an engine and what a scene asks. Out: its document, charts, tables, and shapes for pictures.
"""
