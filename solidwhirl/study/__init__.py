"""Error against cost over the settings of one scene.

Ladders of `[model]` settings, each case in a process of its own, held against one truth.
In: a scene. Out: a table, one picture, and the numbers as JSON.
"""
