"""Eigenvalues as paths over one real parameter, and the events on them.

`eigenvalue_paths` follows all roots between refined nodes; `events` are zeros of functions on the
paths, solved on the operator itself; `frequency_roots` are those of laws over the frequency.
"""
