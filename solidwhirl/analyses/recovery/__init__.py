"""Displacement and stress in the solid bodies in some states of the engine.

What is asked and told (`analysis`), states of the engine, fields in a body.
In: modes, responses and run-ups of the engine. Out: largest stresses, files of fields.
"""
