"""Pictures of a sweep.

Bands, tornado, lines, margins, parallel coordinates.
In: `SweepAnalysis`. Out: pictures and the numbers behind them.
"""
