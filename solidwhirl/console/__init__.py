"""The terminal: progress, summary, exit handling, doctor, scenes to begin with.

Standard streams that never end a command; one message and exit code 2 for bad input.
In: events of a run. Out: text.
"""
