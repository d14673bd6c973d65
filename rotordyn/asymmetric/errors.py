"""What a reduction left out of the bodies, seen by a motion in the frame that turns."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics
from solidwhirl.rotordyn.core.arrays import Matrix
from solidwhirl.rotordyn.superelement.record import Superelement
from solidwhirl.rotordyn.superelement.residual_energy import form_products, form_weight


def dynamic_change(
    rotating: RotatingSystem, value: complex, speed_rad_s: float, left: Harmonics, right: Harmonics
) -> dict[str, complex]:
    """Return yᴴ (E − Ω²ΔK2) x by part of what was left out, with safety and amplification.

    `value`: λ of the motion x = e^{λt} Σ e^{ihθ} x_h, (n,) each; `left`: its left vector. A body
    whose matrices are those of fixed axes sees the circles of its motion one by one.
    """
    found: dict[str, complex] = {}
    for name, rotor in rotating.system.rotors.items():
        element, rows = rotor.element, rotating.transformation[rotating.body_slices[name]]
        own = rotor.speed_ratio / abs(rotating.frame_ratio) * speed_rad_s
        circles = _circles(element) if name in rotating.turned else [(0, np.eye(element.size))]
        for form in element.error_forms:
            for h in right.keys() & left.keys():
                for order, part in circles:
                    rate = value + 1j * (h + order * rotating.sense) * speed_rad_s
                    x, y = (part @ rows @ a[h] for a in (right, left))
                    product = form_products(form, [rate], own, y.conj()[:, None], x[:, None])[0]
                    weighted = complex(product * form_weight(form, rate))
                    found[form.part] = found.get(form.part, 0.0) + weighted
    return found


def _circles(element: Superelement) -> list[tuple[int, Matrix]]:
    """Orders and projectors of motions that the turn of a body multiplies by i times the order."""
    turn = element.spin_generator
    if turn is None:
        return [(0, np.eye(element.size))]
    across = -turn @ turn
    return [
        (0, np.eye(element.size) - across),
        (1, 0.5 * (across - 1j * turn)),
        (-1, 0.5 * (across + 1j * turn)),
    ]
