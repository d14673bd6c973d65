"""Modal tests of a system that stands still or turns.

What a hammer and sensors would find, and how measured modes compare with computed ones.
In: an assembled system, places along its bodies. Out: frequency response functions, modes
that belong together.
"""
