"""What an engineer draws: materials, meridian sections, stages, interfaces, mass properties.

The rotation axis is z; bodies of revolution are drawn in the half-plane (z, r), r >= 0, SI units.
"""

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.feature_shapes import side_view
from solidwhirl.geometry.feature_symmetry import common_sectors, mirror_angle
from solidwhirl.geometry.features import Blade, Feature, Hole, Slot, sector_count
from solidwhirl.geometry.mass_properties import (
    MassProperties,
    feature_mass_properties,
    feature_material,
    mass_by_material_kg,
    mass_properties,
    section_mass_properties,
)
from solidwhirl.geometry.materials import MATERIALS, Material
from solidwhirl.geometry.meridian.fillet_merge import merge_fillets
from solidwhirl.geometry.meridian.subdivision import Corner, Curve, Face, Subdivision, subdivide
from solidwhirl.geometry.parts import PartLayout, has_stages, layout_of
from solidwhirl.geometry.profile import Body, Coupling, Interface, InterfaceKind, RigidDisk, Section
from solidwhirl.geometry.stages import (
    TABLE_7,
    Cone,
    StageBlades,
    StageGroup,
    Web,
    stage_group_blades,
    stage_group_sections,
    stage_values,
)

__all__ = [
    "MATERIALS",
    "TABLE_7",
    "Blade",
    "Body",
    "Cone",
    "Corner",
    "Coupling",
    "Curve",
    "Face",
    "Feature",
    "GeometryError",
    "Hole",
    "Interface",
    "InterfaceKind",
    "MassProperties",
    "Material",
    "PartLayout",
    "RigidDisk",
    "Section",
    "Slot",
    "StageBlades",
    "StageGroup",
    "Subdivision",
    "Web",
    "common_sectors",
    "feature_mass_properties",
    "feature_material",
    "has_stages",
    "layout_of",
    "mass_by_material_kg",
    "mass_properties",
    "merge_fillets",
    "mirror_angle",
    "section_mass_properties",
    "sector_count",
    "side_view",
    "stage_group_blades",
    "stage_group_sections",
    "stage_values",
    "subdivide",
]
