"""Results as documents: results.json, report, comparison.

The folder of a run is written by `write_results`.
In: `Results`. Out: files and plain data.
"""
