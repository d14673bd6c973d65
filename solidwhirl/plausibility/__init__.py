"""Warnings about numbers a thousand times off from what rotors have.

Units, shapes, speeds, supports.
In: `Scene` and bodies. Out: warnings.
"""
