"""From a scene to bodies, parts of the system, and the effects plan.

Parametric, meshed and imported bodies, joints, balance grades, resolution.
In: `Scene`. Out: bodies, system parts, `Plan`.
"""
