"""Lateral analysis of API 617: what is asked, what is computed, clause by clause.

In: the engine and what the scene says of one shaft. Out: the document of the analysis, and what a
page tells of it.
"""
