"""What a run will cost in unknowns, time and memory.

Measured laws, their coefficients, the forecast and its table.
In: `Plan`. Out: `Forecast`, or a refusal of what does not fit.
"""
