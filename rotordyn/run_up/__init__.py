"""Transient run-up with a varying speed.

Exponential integration, loads, records, force spectra, and models of less complexity.
In: `AssembledSystem`, a speed profile, loads. Out: `RunUp`.
"""
