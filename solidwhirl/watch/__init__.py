"""A page on this machine that follows a scene: the file as it is saved, and sliders for supports.

Reduced bodies are kept; what changes nothing of them is shown within a tenth of a second.
In: a scene file or the folder of a run. Out: a page on the loopback address, numbers in the file.
"""
