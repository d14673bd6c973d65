"""Responses, run-ups, maps, recovery and state space on a page.

One section or chart a module.
In: results. Out: blocks.
"""
