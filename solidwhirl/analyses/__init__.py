"""The analyses of a scene beyond diagram and critical speeds.

Design, modes, responses, run-ups, recovery, stability.
In: the assembled engine and an entry of [[analyses]]. Out: `Outcome`.
"""
