"""The records of a scene file, checked by pydantic.

One module for each group of tables.
In: plain data. Out: `Scene`.
"""

from __future__ import annotations

from solidwhirl.scene.records import Scene as Scene
