"""Campbell diagram, critical speeds and mode shapes on a page.

One section or chart a module.
In: results. Out: blocks.
"""
