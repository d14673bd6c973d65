"""One body with one discretisation, and its adaptive refinement.

Reduction, refinement to the accuracy asked, model fidelity.
In: geometry and plan. Out: `BodyResult`, rounds of refinement.
"""
