"""Formats of plain matrices: npz, DMIG, OUTPUT4, Matrix Market.

Written with the rows and units beside them, and read back.
In: `Superelement` or files. Out: files or `ForeignBody`.
"""
