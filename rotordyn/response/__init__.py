"""Steady response: unbalance, harmonic loads, maps, and margins judged by it.

Solutions at given speeds, samples where resonances are sharp, summits, orbits.
In: `AssembledSystem`, loads, speeds. Out: amplitudes, orbits, bearing forces, peaks.
"""
