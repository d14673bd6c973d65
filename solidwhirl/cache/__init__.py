"""Completed stages on disk, found again by what went into them.

Records as bytes and back, fingerprints, locks.
In: frozen records. Out: the same, bit for bit.
"""
