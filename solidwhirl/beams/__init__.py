"""The beam level: a Timoshenko model made from the profile of a body.

Columns that bend, plates that tilt, fillets, seats, and how far beam theory may be off.
In: a body of revolution. Out: `Superelement`.
"""
