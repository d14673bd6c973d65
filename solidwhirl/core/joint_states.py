"""What the pressed faces of a body's joints do over the speed: free of the solvers."""

from __future__ import annotations

from dataclasses import dataclass

from solidwhirl.rotordyn.core.arrays import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class JointState:
    """One joint whose faces are pressed together, of a body that spins freely."""

    between: tuple[str, str]
    interference_m: float | None  #: Overlap of the radii that is left; None of plane faces
    friction: float
    area_m2: float  #: Of the face that carries
    along_m: FloatArray  #: (q,) places on the face: z, of plane faces r
    speeds_rad_s: FloatArray  #: (s,) from rest to the largest speed
    pressure_pa: FloatArray  #: (s, q) 0 where the face has lifted
    mean_pressure_pa: FloatArray  #: (s,) over all of the face
    lifted_part: FloatArray  #: (s,) of the area
    torque_n_m: FloatArray  #: (s,) that friction carries before the face slips
    #: (s, 2) mean over the face of the von Mises stress beside it, in either section
    stress_pa: FloatArray
    lifts_at_rad_s: float | None  #: Where the first place lifts; None: nowhere
    loose_at_rad_s: float | None  #: Where the last one does
