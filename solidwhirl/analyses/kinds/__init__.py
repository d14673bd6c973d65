"""The kinds of analysis, one file each: scene record, computation, document, headline.

A new kind is a class of `analyses.base.Analysis` in a file here, and a line in the registry.
In: `Engine`. Out: `Outcome`.
"""
