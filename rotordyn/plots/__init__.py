"""Pictures of results with matplotlib.

One module for each kind of result, one frame for all of them.
In: records of this stage. Out: figures, files.
"""
