"""Responses to loads and unbalance: at rest, over the speed, in time; one file each kind.

As in `kinds`: scene record, computation, document, headline.
In: `Engine`. Out: `Outcome`.
"""
