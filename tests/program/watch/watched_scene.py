"""A beam in a scene file with comments, and what a session tells of a scene."""

from __future__ import annotations

import json
import threading

SCENE = """\
# A beam on two bearings; what stands behind # is kept.
name = "scene"
title = "Beam on two bearings"

[speeds]  # of the reference shaft
to_rpm = 20000
count = 21

[campbell]
branches = 4

[beams.rotor]
material = "steel"
stations_m = [0.0, 0.1, 0.2, 0.3, 0.4]
outer_radius_m = [0.02]
interfaces = { a = 0.0, b = 0.4 }
disks = [
    { name = "wheel", at_m = 0.2, mass_kg = 8.0, polar_inertia_kg_m2 = 0.04, diametral_inertia_kg_m2 = 0.02 },
]

[[bearings]]
name = "a"  # the front one
first = "rotor.a"
stiffness_n_per_m = [1e7,   2e7]   # x and y, N/m
damping_n_s_per_m = 500.0

[[bearings]]
name = "b"
first = "rotor.b"
stiffness_n_per_m = 1e7

[[operating]]
shaft = "rotor"
from_rpm = 9000
to_rpm = 9500
"""  # noqa: E501


class Told:
    """What a session tells, and waiting for it."""

    def __init__(self):
        self.messages, self.everything = [], []
        self._changed = threading.Condition()

    def __call__(self, text):
        with self._changed:
            self.messages.append(json.loads(text))
            self.everything.append(self.messages[-1])
            self._changed.notify_all()

    def wait(self, kind, wanted=lambda message: True):
        """The first message of a kind that is as wanted; all up to it are forgotten."""
        found = []

        def is_there():
            for k, message in enumerate(self.messages):
                if message["kind"] == kind and wanted(message):
                    found[:] = [message]
                    del self.messages[: k + 1]
                    return True
            return False

        with self._changed:
            assert self._changed.wait_for(is_there, 120), [
                (m["kind"], m.get("problems")) for m in self.messages
            ]
        return found[0]

    def last(self, kind):
        """The last message of a kind so far, forgotten or not."""
        with self._changed:
            return [m for m in self.everything if m["kind"] == kind][-1]
