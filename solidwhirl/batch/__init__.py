"""Many cases on an executor: the ranks of a job, a user's own workers, or this process alone.

In: scenes, with `[sweep]` or without. Out: one folder and one row for each case, kept safely in
journal and table.
"""
