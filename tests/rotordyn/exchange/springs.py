"""Springs between bodies, and a body alone on springs, as the program has it."""

from __future__ import annotations

from rotors import connect, turning

from solidwhirl.rotordyn import End, assemble, modes_at_speed


def spring(first, stiffness, damping=0.0, second=None, **more):
    """Bearing between (body, interface) and another or the ground, in N/m and N s/m."""
    ends = [end and End(body=end[0], interface=end[1]) for end in (first, second)]
    return connect(f"{first} {second} {stiffness}", *ends, stiffness, damping, **more)


def on_springs(element, lateral, axial=None, torsion=None):
    """System of the body "r" on springs to the ground, by interface; axial N/m, torsion N m/rad."""
    bearings = tuple(
        spring(
            ("r", name),
            stiffness,
            axial_stiffness_n_per_m=(axial or {}).get(name, 0.0),
            torsion_stiffness_n_m_per_rad=(torsion or {}).get(name, 0.0),
        )
        for name, stiffness in lateral.items()
    )
    return assemble({"r": turning(element)}, bearings)


def inertial_modes(element, springs, speed):
    """Modes of a body on springs {interface: (lateral, axial) N/m} at a speed in rad/s."""
    lateral, axial = ({name: k[i] for name, k in springs.items()} for i in (0, 1))
    return modes_at_speed(on_springs(element, lateral, axial), speed)
