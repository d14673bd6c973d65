"""Superelements in the files of other programs, and back.

One module for each format, in three groups: matrices, multibody programs, Python programs.
In: `Superelement`. Out: files and what their format could not carry.
"""
