"""What drawings of an engine show, before anything is drawn.

Bodies in section, the engine drawing as plain shapes, modes as surfaces that move.
In: a run. Out: geometry for the page (SVG, WebGL) and for print (matplotlib, VTK).
"""
