"""What a reduction left out of the bodies, seen by a motion in the frame that turns."""

from __future__ import annotations

import numpy as np

from solidwhirl.rotordyn.asymmetric.assembly import RotatingSystem
from solidwhirl.rotordyn.asymmetric.periodic import Harmonics, circles
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
        turn = element.spin_generator if name in rotating.turned else None
        orders = {0: np.eye(element.size)} if turn is None else circles(turn)
        for form in element.error_forms:
            for h in right.keys() & left.keys():
                for order, part in orders.items():
                    rate = value + 1j * (h + order * rotating.sense) * speed_rad_s
                    x, y = (part @ rows @ a[h] for a in (right, left))
                    product = form_products(form, [rate], own, y.conj()[:, None], x[:, None])[0]
                    weighted = complex(product * form_weight(form, rate))
                    found[form.part] = found.get(form.part, 0.0) + weighted
    return found
