"""Errors of everything that a run reports, split into parts.

Mesh, modes, coupling, speed, beam theory; peaks of responses.
In: results and models beside them. Out: relative errors and their documents.
"""
