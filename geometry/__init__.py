"""What an engineer draws: materials, meridian sections, stages, interfaces, mass properties.

The rotation axis is z; bodies of revolution are drawn in the half-plane (z, r), r >= 0, SI units.
"""

from solidwhirl.geometry.errors import GeometryError
from solidwhirl.geometry.feature_shapes import side_view
from solidwhirl.geometry.feature_symmetry import mirror_angle
from solidwhirl.geometry.features import (
    Blade,
    Feature,
    Flat,
    Hole,
    Keyway,
    Recess,
    RingCut,
    Slot,
    offsets_rad,
    places_rad,
    sector_count,
)
from solidwhirl.geometry.joints import Joint
from solidwhirl.geometry.mass_properties import (
    MassProperties,
    feature_mass_properties,
    feature_material,
    mass_by_material_kg,
    mass_properties,
    masses_beyond_kg,
    section_mass_properties,
    sections_beyond_kg,
)
from solidwhirl.geometry.materials import MATERIALS, Material
from solidwhirl.geometry.meridian.fillet_merge import merge_fillets
from solidwhirl.geometry.meridian.subdivision import Corner, Curve, Face, Subdivision, subdivide
from solidwhirl.geometry.parts import PartLayout, Symmetry, layout_of, symmetry
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
    "Flat",
    "GeometryError",
    "Hole",
    "Interface",
    "InterfaceKind",
    "Joint",
    "Keyway",
    "MassProperties",
    "Material",
    "PartLayout",
    "Recess",
    "RigidDisk",
    "RingCut",
    "Section",
    "Slot",
    "StageBlades",
    "StageGroup",
    "Subdivision",
    "Symmetry",
    "Web",
    "feature_mass_properties",
    "feature_material",
    "layout_of",
    "mass_by_material_kg",
    "mass_properties",
    "masses_beyond_kg",
    "merge_fillets",
    "mirror_angle",
    "offsets_rad",
    "places_rad",
    "section_mass_properties",
    "sections_beyond_kg",
    "sector_count",
    "side_view",
    "stage_group_blades",
    "stage_group_sections",
    "stage_values",
    "subdivide",
    "symmetry",
]
