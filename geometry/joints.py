"""Joints between the sections of a body: parts that touch on a common face, and are not one."""

from __future__ import annotations

from dataclasses import dataclass

from solidwhirl.geometry.errors import GeometryError, require_finite


@dataclass(frozen=True, kw_only=True, slots=True)
class Joint:
    """Part two sections along their common face, and join them by a layer of springs.

    With `interference_m` or `pressure_pa` the faces are pressed together: what is closed is bonded.
    Raises GeometryError for values that no joint can have.
    """

    between: tuple[str, str]  #: Names of the two sections
    #: Springs per area [N/m³], normal to the face and along it; of pressed faces of what is closed.
    #: None: stiff as bonded
    stiffness_n_per_m3: tuple[float, float] | None = None
    #: By how much the faces overlap at rest and at one temperature, along the normal [m]
    interference_m: float | None = None
    #: Mean pressure at rest and at one temperature [Pa]; instead of the interference
    pressure_pa: float | None = None
    #: Part of the face that carries, along z [m], of a plane z = const along r; elsewhere the faces
    #: are apart. None: all of it
    over_m: tuple[float, float] | None = None
    #: By how much the part around the face is warmer than the one within [K], and its expansion
    temperature_difference_k: float = 0.0
    expansion_per_k: float = 0.0
    friction: float = 0.12  #: Coefficient of friction for the torque that the face carries
    yield_pa: float | None = None  #: Yield strength of the two sections [Pa]; None: not judged

    def __post_init__(self) -> None:
        where = self.where
        if self.between[0] == self.between[1]:
            raise GeometryError(f"{where}: a joint needs two sections, found one twice")
        given = (self.stiffness_n_per_m3, self.interference_m, self.pressure_pa)
        if self.interference_m is not None and self.pressure_pa is not None:
            raise GeometryError(
                f"{where}: interference_m and pressure_pa are both given; keep one of them"
            )
        require_finite(where, *(v for v in given[1:] if v is not None), *(given[0] or ()))
        if self.over_m is not None and self.over_m[1] <= self.over_m[0]:
            raise GeometryError(
                f"{where}: over_m is {list(self.over_m)}; the end must lie beyond the start"
            )

    def refuse_untold(self) -> None:
        """Refuse a joint of which nothing says how it joins; of a drawing its overlap may.

        Raises GeometryError.
        """
        if self.stiffness_n_per_m3 is None and not self.is_pressed:
            raise GeometryError(
                f"{self.where}: nothing says how it joins; give stiffness_n_per_m3, "
                "interference_m or pressure_pa"
            )

    @property
    def where(self) -> str:
        """How messages call it."""
        return f"joint between {self.between[0]!r} and {self.between[1]!r}"

    @property
    def is_pressed(self) -> bool:
        """Whether the faces are pressed together, so that they may lift."""
        return self.interference_m is not None or self.pressure_pa is not None
