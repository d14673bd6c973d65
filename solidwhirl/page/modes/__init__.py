"""Campbell diagram, critical speeds, mode shapes and stability on a page.

One section or chart a module.
In: results. Out: blocks.
"""
