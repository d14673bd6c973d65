"""What a scene refers to and asks for, checked before anything is meshed.

References, analyses, weight, operating speeds, motions of interfaces.
In: `Scene`. Out: refusals with key and reason, speeds and motions asked for.
"""
