"""An MBDyn input that holds a modal body on springs, to start from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from solidwhirl.rotordyn.arrays import FloatArray
from solidwhirl.rotordyn.body_fixed import BodyFixedForm

_HEAD = """\
# Body "{name}" from {file}, spinning freely about z on springs to the ground.
# Units kg, m, s, rad. Set the spin, the springs and the times to yours.

set: real SPIN = 100.; # rad/s
set: real RADIAL = {radial:.3e}; # N/m, of each spring in x and y
set: real AXIAL = {radial:.3e}; # N/m, in z
set: real STEP = {step:.3e}; # s
set: real END = {end:.3e}; # s

set: integer BODY = 1;
set: integer GROUND = 2;
set: integer INTERFACE = 100;
set: integer SPRING = 200;

begin: data;
    problem: initial value;
end: data;

begin: initial value;
    initial time: 0.;
    final time: END;
    time step: STEP;
    method: ms, 0.6;
    tolerance: 1.e-6;
    max iterations: 20;
    derivatives coefficient: 1.e-9;
    derivatives tolerance: 1.e-3;
    derivatives max iterations: 20;
end: initial value;

begin: control data;
{differentiation}    structural nodes:
        + 1 # frame of the body
        + 1 # ground
        + {count} # interfaces
    ;
    joints:
        + 1 # body
        + 1 # ground
        + {count} # springs
    ;
end: control data;

begin: nodes;
    structural: BODY, modal,
        null,
        eye,
        null,
        0., 0., SPIN;
    structural: GROUND, static,
        null,
        eye,
        null,
        null;
"""

_NODE = """\
    structural: INTERFACE + {k}, static,
        {place},
        eye,
        {velocity},
        0., 0., SPIN;
"""

_ELEMENTS = """\
end: nodes;

begin: elements;
    joint: BODY, modal, BODY,
        {modes},
        from file,
        {damping},
        "{file}",
        origin position, null,
        {count}{interfaces}{ninth};
    joint: GROUND, clamp, GROUND,
        position, node,
        orientation, node;
"""

_SPRING = """\
    joint: SPRING + {k}, deformable displacement joint,
        GROUND,
            position, {place},
        INTERFACE + {k},
            position, null,
        linear elastic generic, diag, RADIAL, RADIAL, AXIAL;
"""


def example_input(
    form: BodyFixedForm,
    file: str,
    labels: Sequence[str],
    *,
    level: int,
    modal_damping: float,
) -> str:
    """Return the text of an MBDyn input with one modal body and a spring at every interface.

    Parameters
    ----------
    form
        The body.
    file
        Name of its .fem file.
    labels
        Labels of the interfaces in that file.
    level
        Highest record group of that file.
    modal_damping
        Damping ratio of every mode in that file.

    Returns
    -------
    str
        UTF-8. The springs are as stiff as the first mode, so that the body is neither free nor
        held.
    """
    frequency = float(form.frequencies_hz[0])
    radial = form.mass_kg * (2.0 * np.pi * frequency) ** 2 / max(len(labels), 1)
    values = {
        "name": form.name,
        "file": file,
        "radial": radial,
        "step": 0.01 / frequency,
        "end": 10.0 / frequency,
        "differentiation": "    use automatic differentiation;\n" if level >= 19 else "",
        "count": len(labels),
        "modes": form.frequencies_hz.size,
        "damping": "damping from file" if modal_damping else "no damping",
        # the manual has it before the origin; the program reads it behind the interfaces
        "ninth": ",\n        use invariant 9" if level == 13 else "",
        "interfaces": "".join(
            f',\n        "{label}", INTERFACE + {k}, null' for k, label in enumerate(labels, 1)
        ),
    }
    places = [
        (k, ", ".join(f"{value:.16e}" for value in node.position_m), node.position_m)
        for k, node in enumerate(form.nodes, 1)
    ]
    return "".join(
        [
            _HEAD.format(**values),
            *(_NODE.format(k=k, place=text, velocity=_velocity(at)) for k, text, at in places),
            _ELEMENTS.format(**values),
            *(_SPRING.format(k=k, place=text) for k, text, _ in places),
            "end: elements;\n",
        ]
    )


def _velocity(position_m: FloatArray) -> str:
    """Return the velocity of a place on the spinning body as an expression."""
    x, y = float(position_m[0]), float(position_m[1])
    if x == y == 0.0:
        return "null"
    return f"-SPIN*({y:.16e}), SPIN*({x:.16e}), 0."
