"""Error estimates of frequencies, diagrams, critical speeds and peaks.

From the residual energy of the bodies, and from differences between models.
In: results and their system. Out: errors, relative, split into parts.
"""
