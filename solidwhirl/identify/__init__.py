"""Parameter identification from measurements.

Bounded least squares over keys of a scene, and how well the data determine them.
In: a problem file. Out: values with intervals, a scene that holds them.
"""
