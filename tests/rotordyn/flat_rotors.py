"""Asymmetric bodies, in the frame that turns with them."""

from __future__ import annotations

import dataclasses

import numpy as np
from bladed_hub import HUB, BladedHub
from rotors import lumped_hub

from solidwhirl.rotordyn import rigid_superelement
from solidwhirl.rotordyn.asymmetric import Joint, turning_body
from solidwhirl.rotordyn.superelement.mass_moments import MassMoments

CROSS = np.array([[0.0, -1.0], [1.0, 0.0]])


def on_shaft(mass, stiffness, damping=0.0):
    """A mass in the middle of a flat shaft (2 directions), damped from outside."""
    matrices = {
        "mass": mass * np.eye(2),
        "gyroscopic": 2.0 * mass * CROSS,
        "stiffness": np.diag(stiffness),
        "centrifugal_stiffness": -mass * np.eye(2),
    }
    motion = np.eye(6, 2)
    joint = Joint(motion, np.zeros((6, 6)), np.diag([damping, damping, 0.0, 0.0, 0.0, 0.0]))
    return turning_body(matrices, [joint])


def two_blades(springs, damping=(0.0, 0.0), cross=0.0):
    """A hub of 7 on springs along x and y with two lag hinges at 0.2, masses 1, springs 2."""
    hub = BladedHub(count=2, springs=np.diag([2.0, 50.0]))
    plane = np.ix_(*[[0, 1, 6, 8]] * 2)
    mass, coriolis, stiffness, stress, softening = (a[plane] for a in hub.direct)
    matrices = {
        "mass": mass,
        "gyroscopic": 2.0 * coriolis,
        "stiffness": stiffness,
        "centrifugal_stiffness": stress - softening,
    }
    spring, drag = np.zeros((2, 6, 6))
    spring[:2, :2] = np.diag(springs) - cross * CROSS
    drag[:2, :2] = np.diag(damping)
    turning = (mass, coriolis, stiffness, stress - softening)
    hold = (spring[:2, :2], drag[:2, :2], np.zeros((2, 2)), np.zeros((2, 2)))
    return turning_body(matrices, [Joint(np.eye(6, 4), spring, drag)]), (turning, hold)


def flat_mass(mass, stiffness=None, center=(0.0, 0.0)):
    """Superelement of a mass, off its axis by `center`, that springs of its own tie to the axis."""
    seats = {"hub": 0.0}
    even = rigid_superelement("mass", mass, [*center, 0.0], [1.0] * 3, seats, ("ux", "uy"))
    element = in_its_frame(even)
    if stiffness is None:
        return element
    free = np.zeros(6, dtype=bool)
    return dataclasses.replace(element, stiffness=np.diag(stiffness), rigid_body_present=free)


def bladed(hub):
    """Superelement of all coordinates of a bladed hub in its own frame."""
    mass, coriolis, stiffness, stress, softening = hub.direct
    matrices = {
        "mass": mass,
        "gyroscopic": 2.0 * coriolis,
        "stiffness": stiffness,
        "stress_stiffening": stress,
        "spin_softening": softening,
    }
    first, second = np.zeros((3, 3, hub.size)), np.zeros((3, 3, hub.size, hub.size))
    simple = np.zeros((3, hub.size))
    for m, place, blade in hub.places():
        motion = np.array([hub.first(place, blade, e) for e in np.eye(hub.size)]).T
        simple += m * motion
        first += m * np.multiply.outer(place, motion)
        second += m * np.einsum("aj,bk->abjk", motion, motion)
    rigid = mass[:6, :6]
    return dataclasses.replace(
        lumped_hub("hub", matrices, HUB, None),
        mass_kg=float(rigid[0, 0]),
        inertia_kg_m2=rigid[3:, 3:],
        frame="rotating",
        moments=MassMoments(displacement_kg=simple, first_kg_m=first, second_kg=second),
    )


def in_its_frame(element):
    """A body of revolution in the frame that turns with it, q at rest = e^{θL} q."""
    turn, mass, moments = element.spin_generator, element.mass, element.moments
    change = element.stress_stiffening - element.spin_softening
    change = change + element.gyroscopic @ turn + mass @ turn @ turn
    softening = moments.second_kg[0, 0] + moments.second_kg[1, 1]
    coriolis = element.gyroscopic + 2.0 * mass @ turn
    return dataclasses.replace(
        element,
        frame="rotating",
        gyroscopic=0.5 * (coriolis - coriolis.T),
        stress_stiffening=0.5 * (change + change.T) + softening,
        spin_softening=softening,
        spin_generator=None,
        surface=None,
        error_forms=(),
    )
