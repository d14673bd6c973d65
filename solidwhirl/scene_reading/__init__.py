"""Scene files: reading, and messages with file, key, line and column.

TOML places, paths of keys, places of sweeps.
In: a path. Out: `Scene`, or one clear message.
"""
