"""The reduction of one body, from mesh to superelement.

Circumferential orders put together, mass moments, surface, verification.
In: a mesh and a request. Out: `Superelement` with checks.
"""
