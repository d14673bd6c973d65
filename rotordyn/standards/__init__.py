"""Formulas of standards on the vibration of rotors: numbers in, numbers out.

API 617 (lateral analysis, stability), ISO 20816-3 (vibration of shafts), ISO 21940-11 (balance).
What they ask of a system is computed elsewhere.
"""
