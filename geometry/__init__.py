"""What an engineer draws: materials, meridian sections, stages, interfaces, mass properties.

The rotation axis is z; bodies of revolution are drawn in the half-plane (z, r), r >= 0, SI units.
"""

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.mass_properties import (
    MassProperties,
    mass_by_material_kg,
    mass_properties,
    section_mass_properties,
)
from solidwhirl.geometry.materials import MATERIALS, Material
from solidwhirl.geometry.meridian.fillet_merge import merge_fillets
from solidwhirl.geometry.meridian.subdivision import Corner, Curve, Face, Subdivision, subdivide
from solidwhirl.geometry.profile import Body, Coupling, Interface, InterfaceKind, RigidDisk, Section
from solidwhirl.geometry.stages import (
    TABLE_7,
    Cone,
    StageGroup,
    Web,
    stage_group_sections,
    stage_values,
)

__all__ = [
    "MATERIALS",
    "TABLE_7",
    "Body",
    "Cone",
    "Corner",
    "Coupling",
    "Curve",
    "Face",
    "GeometryError",
    "Interface",
    "InterfaceKind",
    "MassProperties",
    "Material",
    "RigidDisk",
    "Section",
    "StageGroup",
    "Subdivision",
    "Web",
    "mass_by_material_kg",
    "mass_properties",
    "merge_fillets",
    "section_mass_properties",
    "stage_group_sections",
    "stage_values",
    "subdivide",
]
