"""What every part of the program stands on.

Errors, versions, machine, plain data, warnings, outcomes, texts of records.
In: nothing of the program. Out: functions and types that its packages call.
"""
