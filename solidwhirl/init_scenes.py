"""Scenes to begin with: complete, commented, and ready to run as they are written."""

from __future__ import annotations

from collections.abc import Mapping
from string import Template

_LAVAL = """\
# A shaft with one disk between two bearings.
#
#   solidwhirl plan $file                    what will be computed, and what it costs
#   solidwhirl run $file --out out/$name    the results: open out/$name/report.html
#
# Units are in the keys: metres, kilograms, newtons, seconds; speeds in rpm. The axis of rotation
# is z. Every key that a scene may have is explained in docs/scene.md. Lines that begin with "#="
# are further keys with values that work: remove the "#=" to use them.
name = "$name"
title = "Shaft with one disk on two bearings"
notes = ["Bearing stiffness and damping are assumed."]

[model]
accuracy = 2e-3               # relative error allowed in frequencies and critical speeds
#= level = "harmonic"         # "beam", "harmonic" or "solid"; left out, the program chooses

[speeds]                      # of the shaft; the last one ends the search for critical speeds
from_rpm = 0
to_rpm = 12000
count = 13

[campbell]
branches = 6                  # lowest modes that the Campbell diagram shows

# The solid: pieces of the meridian that touch are one piece of metal. Radii may differ at the two
# ends: outer_radius_m = [0.02, 0.03]. A hollow piece has an inner_radius_m.
[bodies.rotor]
material = "steel"            # or titanium, nickel_alloy, aluminium, or one of your own, see below
sections = [
    { name = "shaft", start_m = 0.0, end_m = 0.6, outer_radius_m = 0.015 },
    { name = "disk", start_m = 0.28, end_m = 0.32, inner_radius_m = 0.015, outer_radius_m = 0.12 },
]
# Places that bearings, unbalances and results refer to as "rotor.left" and so on.
interfaces = [
    { name = "left", kind = "section", at_m = 0.0 },
    { name = "disk", kind = "section", at_m = 0.3 },
    { name = "right", kind = "section", at_m = 0.6 },
]
#= fillet_radius_m = 0.003    # at every re-entrant corner

#= [materials.my_steel]
#= density_kg_per_m3 = 7850
#= youngs_modulus_pa = 2.1e11
#= poissons_ratio = 0.3

# A bearing joins an interface to the ground, or to another one: second = "body.interface".
# One number is the same stiffness in x and y, [kx, ky] are two, [[kxx, kxy], [kyx, kyy]] a matrix.
[[bearings]]
name = "left"
first = "rotor.left"
stiffness_n_per_m = [2e7, 3e7]
damping_n_s_per_m = 500

[[bearings]]
name = "right"
first = "rotor.right"
stiffness_n_per_m = [2e7, 3e7]
damping_n_s_per_m = 500

# What is computed beside the Campbell diagram and the critical speeds.
[[analyses]]
kind = "unbalance_response"
unbalances = [{ at = "rotor.disk", moment_kg_m = 1e-4 }]   # mass times distance from the axis
observe = ["rotor.disk", "rotor.left"]
to_rpm = 12000
count = 241

[[analyses]]
kind = "separation_margins"
operating = [{ shaft = "rotor", from_rpm = 5500, to_rpm = 6000 }]

#= [[analyses]]
#= kind = "stability"
#= to_rpm = 12000

#= [[analyses]]
#= kind = "mode_shapes"
#= speeds_rpm = [0, 6000]
"""

_TWIN = """\
# Two coaxial shafts that turn against each other, the outer one on a bearing between the two.
#
#   solidwhirl plan $file
#   solidwhirl run $file --out out/$name
#
# Keys are explained in docs/scene.md, and the first ones in what `solidwhirl init --kind laval`
# writes. Lines that begin with "#=" are further keys: remove the "#=" to use them.
name = "$name"
title = "Coaxial twin rotor with an intershaft bearing"
notes = ["Dimensions are made up; stiffnesses are of the size that rolling bearings have."]

[model]
accuracy = 5e-3

[speeds]                      # of the reference shaft: of bodies with speed_ratio = 1
to_rpm = 15000
count = 16

[campbell]
branches = 8

[bodies.inner]
speed_ratio = 1.0
material = "steel"
sections = [
    { name = "shaft", start_m = 0.0, end_m = 0.5, outer_radius_m = 0.02 },
    { name = "disk", start_m = 0.12, end_m = 0.15, inner_radius_m = 0.02, outer_radius_m = 0.14 },
]
interfaces = [
    { name = "front", kind = "section", at_m = 0.0 },
    { name = "disk", kind = "section", at_m = 0.135 },
    { name = "middle", kind = "section", at_m = 0.3 },
    { name = "rear", kind = "section", at_m = 0.5 },
]

[bodies.outer]
speed_ratio = -1.4            # 1.4 times as fast, the other way round
material = "steel"
sections = [
    { name = "tube", start_m = 0.28, end_m = 0.45, inner_radius_m = 0.03, outer_radius_m = 0.036 },
    { name = "disk", start_m = 0.37, end_m = 0.395, inner_radius_m = 0.036, outer_radius_m = 0.1 },
]
interfaces = [
    { name = "intershaft", kind = "inner", start_m = 0.29, end_m = 0.31 },  # a seat in the bore
    { name = "disk", kind = "section", at_m = 0.3825 },
    { name = "rear", kind = "outer", start_m = 0.43, end_m = 0.45 },        # a seat outside
]

[[bearings]]
name = "front"
first = "inner.front"
stiffness_n_per_m = 5e7
damping_n_s_per_m = 300

[[bearings]]
name = "rear"
first = "inner.rear"
stiffness_n_per_m = 5e7
damping_n_s_per_m = 300

[[bearings]]
name = "intershaft"           # between the two shafts
first = "outer.intershaft"
second = "inner.middle"
stiffness_n_per_m = 2e7
damping_n_s_per_m = 100

[[bearings]]
name = "outer"
first = "outer.rear"
stiffness_n_per_m = 3e7
damping_n_s_per_m = 300

[[analyses]]
kind = "unbalance_response"   # the two shafts excite at different frequencies, each is shown apart
unbalances = [
    { at = "inner.disk", moment_kg_m = 1e-4 },
    { at = "outer.disk", moment_kg_m = 1e-4 },
]
observe = ["inner.disk", "outer.disk"]
to_rpm = 15000
count = 301

[[analyses]]
kind = "separation_margins"
operating = [
    { shaft = "inner", from_rpm = 9500, to_rpm = 10000 },
    { shaft = "outer", from_rpm = 13300, to_rpm = 14000 },    # speeds of the shaft itself
]

#= [[analyses]]
#= kind = "mode_shapes"
#= speeds_rpm = [0, 10000]

#= [[analyses]]
#= kind = "stability"
#= to_rpm = 15000
"""

_ENGINE = """\
# A small geared engine: fan, gear, low and high pressure shaft in a casing on a mount. Shafts are
# beams and the casing is rigid, so that it runs in seconds; the high pressure rotor is a solid.
#
#   solidwhirl plan $file
#   solidwhirl run $file --out out/$name
#
# Keys are explained in docs/scene.md. Lines that begin with "#=" are further keys: remove the "#="
# to use them.
name = "$name"
title = "Geared engine with two shafts, a casing and a mount"
notes = ["All dimensions, masses and stiffnesses are made up."]

[model]
accuracy = 1e-2

[speeds]                      # of the low pressure shaft, whose speed_ratio is 1
to_rpm = 9000
count = 10

[campbell]
branches = 12

# A shaft as stepped beam: radii of the pieces between the stations, disks at places on it.
[beams.lp]
material = "steel"
stations_m = [0.0, 0.15, 0.5, 0.85, 1.0]
outer_radius_m = [0.03, 0.032, 0.032, 0.03]
inner_radius_m = [0.015]
interfaces = { pinion = 0.0, front = 0.15, middle = 0.5, rear = 0.85, turbine = 1.0 }
#= internal_damping = { stiffness_coefficient_s = 1e-6 }

[[beams.lp.disks]]
name = "turbine"
at_m = 1.0
mass_kg = 20
polar_inertia_kg_m2 = 0.6
diametral_inertia_kg_m2 = 0.33

[beams.fan]
material = "titanium"
speed_ratio = 0.4             # behind the gear
stations_m = [-0.5, -0.1]
outer_radius_m = [0.05]
interfaces = { hub = -0.5, a = -0.4, b = -0.15, gear = -0.1 }

[[beams.fan.disks]]
name = "fan"
at_m = -0.5
mass_kg = 50
polar_inertia_kg_m2 = 5.0
diametral_inertia_kg_m2 = 2.7

# A solid, for its disk bends: a drum around the low pressure shaft.
[bodies.hp]
speed_ratio = 1.6
material = "nickel_alloy"
sections = [
    { name = "drum", start_m = 0.3, end_m = 0.7, inner_radius_m = 0.05, outer_radius_m = 0.06 },
    { name = "disk", start_m = 0.57, end_m = 0.6, inner_radius_m = 0.06, outer_radius_m = 0.17 },
]
interfaces = [
    { name = "front", kind = "outer", start_m = 0.3, end_m = 0.33 },
    { name = "disk", kind = "section", at_m = 0.585 },
    { name = "rear", kind = "inner", start_m = 0.67, end_m = 0.7 },
]

# A casing that does not deform and does not turn.
[rigid_bodies.casing]
mass_kg = 300
center_of_gravity_m = [0, 0, 0.2]
inertia_kg_m2 = [35, 35, 25]
interfaces = { a = -0.4, b = -0.15, front = 0.15, hp = 0.315, rear = 0.85, mount = 0.3 }

[[bearings]]
name = "fan_a"
first = "fan.a"
second = "casing.a"
stiffness_n_per_m = 1e8
damping_n_s_per_m = 2000

[[bearings]]
name = "fan_b"
first = "fan.b"
second = "casing.b"
stiffness_n_per_m = 1e8
damping_n_s_per_m = 2000

[[bearings]]
name = "lp_front"
first = "lp.front"
second = "casing.front"
stiffness_n_per_m = 5e7
damping_n_s_per_m = 1000

[[bearings]]
name = "lp_rear"
first = "lp.rear"
second = "casing.rear"
stiffness_n_per_m = 5e7
damping_n_s_per_m = 1000

[[bearings]]
name = "hp_front"
first = "hp.front"
second = "casing.hp"
stiffness_n_per_m = 8e7
damping_n_s_per_m = 1000

[[bearings]]
name = "intershaft"           # the high pressure rotor runs on the low pressure shaft at its rear
first = "hp.rear"
second = "lp.rear"
stiffness_n_per_m = 3e7
damping_n_s_per_m = 300

[[bearings]]
name = "mount"                # the casing on the aircraft: second is the ground where not given
first = "casing.mount"
stiffness_n_per_m = 1e8
damping_n_s_per_m = 5000
tilt_stiffness_n_m_per_rad = 3e7
torsion_stiffness_n_m_per_rad = 1e8

[[gears]]
name = "gear"
first = "lp.pinion"
second = "fan.gear"
ratio = 0.4                   # speed of the second over that of the first

[[analyses]]
kind = "unbalance_response"
unbalances = [
    { at = "fan.hub", moment_kg_m = 1e-3 },
    { at = "lp.turbine", moment_kg_m = 1e-4 },
    { at = "hp.disk", moment_kg_m = 1e-4 },
]
observe = ["fan.hub", "lp.turbine", "hp.disk"]
to_rpm = 9000
count = 301

[[analyses]]
kind = "separation_margins"
operating = [{ shaft = "lp", from_rpm = 7800, to_rpm = 8200 }]

#= [[analyses]]
#= kind = "run_up"            # in the time domain, with the force on the mount
#= ramp_s = 2
#= to_rpm = 9000
#= sampling_hz = 10000
#= record_hz = 2000
#= unbalances = [{ at = "lp.turbine", moment_kg_m = 1e-4 }]
#= mount = "mount"
"""

KINDS: Mapping[str, tuple[str, str]] = {
    "laval": ("a shaft with one disk on two bearings", _LAVAL),
    "twin": ("two coaxial shafts with an intershaft bearing", _TWIN),
    "engine": ("fan, gear, two shafts, casing and mount", _ENGINE),
}


def scene_text(kind: str, *, name: str, file: str) -> str:
    """Return the text of a scene file.

    Parameters
    ----------
    kind
        One of `KINDS`.
    name
        Of the scene.
    file
        How its comments call the file.
    """
    return Template(KINDS[kind][1]).substitute(name=name, file=file)
