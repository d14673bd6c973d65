"""Joints between sections of a body on its meridian: layers of springs, faces pressed together.

In: a space on a mesh that is parted along the faces. Out: springs, matrices, `JointState`.
"""
