"""Mass moments in a superelement file: one group, absent where they are not known."""

from __future__ import annotations

import h5py
import numpy as np

from solidwhirl.rotordyn.errors import SuperelementError
from solidwhirl.rotordyn.file_checks import SuperelementFile
from solidwhirl.rotordyn.file_format import put_numbers
from solidwhirl.rotordyn.mass_moments import MassMoments

GROUP = "moments"
# Directions a, b of the blocks that are kept; [b, a, k, j] is [a, b, j, k].
_BLOCKS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def write_moments(file: h5py.File, moments: MassMoments | None) -> None:
    """Write the moments of a body; no group is made where there are none.

    Parameters
    ----------
    file
        Open for writing.
    moments
        Of the body.
    """
    if moments is None:
        return
    group = file.create_group(GROUP)
    put_numbers(group, "displacement", moments.displacement_kg, unit="kg", axes="a,coordinate")
    put_numbers(group, "first", moments.first_kg_m, unit="kg m", axes="place a,b,coordinate")
    blocks = np.stack([moments.second_kg[a, b] for a, b in _BLOCKS])
    put_numbers(
        group, "second", blocks, unit="kg", axes="ab(xx,yy,zz,xy,xz,yz),coordinate,coordinate"
    )


def read_moments(file: SuperelementFile, n: int) -> MassMoments | None:
    """Read the moments of a body with n coordinates.

    Parameters
    ----------
    file
        Open for reading.
    n
        Number of coordinates.

    Returns
    -------
    MassMoments or None
        None for a file without them, as those of older versions.

    Raises
    ------
    SuperelementError
        If the group is a link, lacks a dataset, or shapes and numbers are not what moments need.
    """
    if not file.has(GROUP):
        return None
    file.group(GROUP)
    blocks = file.numbers(f"{GROUP}/second", (len(_BLOCKS), n, n))
    second = np.empty((3, 3, n, n))
    for (a, b), block in zip(_BLOCKS, blocks, strict=True):
        second[b, a] = block.T
        second[a, b] = block
    try:
        return MassMoments(
            displacement_kg=file.numbers(f"{GROUP}/displacement", (3, n)),
            first_kg_m=file.numbers(f"{GROUP}/first", (3, 3, n)),
            second_kg=second,
        )
    except SuperelementError as error:
        raise file.named(error) from error
