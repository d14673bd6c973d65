"""What every part of the stage stands on.

Array types, errors, atomic writing, memory, dense eigenproblems, texts of records.
In: nothing of the stage. Out: functions and types that all its packages call.
"""
