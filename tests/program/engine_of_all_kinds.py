"""An engine of beams and a casing with gears, speed laws and every kind of analysis."""

from __future__ import annotations

import tomllib

ENGINE = tomllib.loads("""
name = "engine"
speeds = { to_rpm = 6000.0, count = 3 }
campbell = { branches = 4 }
gears = [{ name = "box", first = "lp.a", second = "hp.a", ratio = -1.5 }]
bearings = [
  { name = "A", first = "lp.a", second = "casing.a", stiffness_n_per_m = 1e7, speed_law="rising" },
  { name = "B", first = "lp.b", second = "casing.b", stiffness_n_per_m = 1e7 },
  { name = "C", first = "hp.a", second = "casing.c", speed_law = "table" },
  { name = "D", first = "hp.b", second = "casing.d", stiffness_n_per_m = 2e7 },
  { name = "mount", first = "casing.a", stiffness_n_per_m = 5e7, damping_n_s_per_m = 1e3 },
]
[beams.lp]
material = "steel"
stations_m = [0.0, 0.5, 1.0]
outer_radius_m = [0.03]
interfaces = { a = 0.0, m = 0.5, b = 1.0 }
internal_damping = { modal_ratio = 1e-4 }
disks = [
  { name = "d", at_m = 0.5, mass_kg = 20, polar_inertia_kg_m2 = 0.4, diametral_inertia_kg_m2 = 0.2 }
]
[beams.hp]
material = "steel"
speed_ratio = -1.5
stations_m = [0.3, 0.7]
outer_radius_m = [0.06]
inner_radius_m = [0.045]
interfaces = { a = 0.3, b = 0.7 }
[rigid_bodies.casing]
mass_kg = 100.0
center_of_gravity_m = [0.0, 0.0, 0.5]
inertia_kg_m2 = [20.0, 20.0, 10.0]
interfaces = { a = 0.0, b = 1.0, c = 0.3, d = 0.7 }
[speed_laws.rising]
kind = "polynomial"
argument_unit = "rpm"
argument_range = [0.0, 20000.0]
stiffness_x = [1.0, 1e-5]
stiffness_y = [1.0, 1e-5]
[speed_laws.table]
kind = "table"
speed_rpm = [0.0, 20000.0]
stiffness_n_per_m = [2e7, [2e7, 3e7]]
damping_n_s_per_m = [500.0, [[500.0, 0.0], [0.0, 400.0]]]
[speed_laws.printed]
kind = "preset"
preset = "lee_isotropic"
""")
KINDS = tomllib.loads("""
place_map = { places = ["lp.m"], observe = "lp.a", moment_kg_m = 1e-5, frequency_max_hz = 150.0 }
waterfall = { observe = "lp.m", to_rpm = 6000.0, speed_count = 3, frequency_max_hz = 150.0 }
rotating_campbell = { bodies = ["lp", "hp"] }
mode_shapes = { speeds_rpm = [0.0, 6000.0], modes = 4, bodies = ["lp"] }
stability = { to_rpm = 6000.0, count = 5 }
bearing_laws = { to_rpm = 6000.0 }
state_space = { inputs = ["lp.m"], outputs = ["lp.a"], to_rpm = 6000.0 }
[unbalance_response]
unbalances = [{ at = "lp.m", moment_kg_m = 1e-5 }]
observe = ["lp.m"]
to_rpm = 6000.0
[critical_speed_map]
bearings = ["B"]
excited_by = "lp"
search_to_rpm = 9000.0
stiffness_from_n_per_m = 1e6
stiffness_to_n_per_m = 1e8
[stiffness_study]
bearings = ["B"]
excite = "lp.m"
observe = "lp.m"
moment_kg_m = 1e-5
operating_speed_rpm = 4000.0
stiffness_from_n_per_m = 1e6
stiffness_to_n_per_m = 1e8
frequency_max_hz = 150.0
[separation_margins]
operating = [{ shaft = "lp", from_rpm = 5000.0, to_rpm = 6000.0 }]
search_factor = 1.5
[run_up]
ramp_s = 0.3
hold_s = 0.2
to_rpm = 6000.0
sampling_hz = 5000.0
record_hz = 2500.0
mount = "mount"
observe = ["lp.m"]
unbalances = [{ at = "lp.m", moment_kg_m = 1e-5 }]
compare_flexible = [["lp"], []]
bands_hz = [[10.0, 90.0]]
[impact_test]
frequency_max_hz = 150.0
frequency_count = 20
damping_ratio = 0.01
hammers = [{ name = "h", at = "lp.m", direction = "x" }]
sensors = [{ name = "s", body = "lp", at_m = 0.4, direction = "x" }]
measured = { frequencies_hz = [30.0, 60.0] }
[static]  # the engine hangs on one mount: weight would turn it
speeds_rpm = [0.0, 6000.0]
gravity_m_per_s2 = [0.0, 0.0, 0.0]
forces = [{ at = "casing.a", force_n = [50.0, -20.0, 0.0] }]
[api617]
shaft = "lp"
minimum_speed_rpm = 3000.0
maximum_continuous_rpm = 5000.0
probes = [{ at = "lp.a", angle_deg = [0.0, 90.0] }]
clearances = [
  { at = "lp.m", diametral_m = 3e-4 },
  { at = "lp.b", diametral_m = 3e-4, floating_ring = true },
]
stages = [{ at = "lp.m", power_w = 1e5, diameter_m = 0.4, height_m = 0.02, density_ratio = 1.2 }]
level_2 = [{ name = "seal", cross_couplings = [{ at = "lp.m", stiffness_n_per_m = 1e4 }] }]
overhangs = [{ bearing = "B", mass_kg = 2.0 }]
[nonlinear_response]
unbalances = [{ at = "lp.m", moment_kg_m = 1e-5 }]
nonlinear = [{ first = "lp.m", second = "casing.c", kind = "cubic", radial_n_per_m3 = 1e16 }]
from_rpm = 1000.0
to_rpm = 2000.0
observe = ["lp.m"]
""")
ENGINE["analyses"] = [{"kind": kind, **analysis} for kind, analysis in KINDS.items()]
