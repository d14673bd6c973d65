"""Kinds of analysis that find modes, speeds and stability, one file each.

Scene record, computation, document, headline. A new kind is a class of `analyses.base.Analysis` in
a file here, or beside it in `responses`, and a line in the registry.
In: `Engine`. Out: `Outcome`.
"""
