"""Messages between rank 0 of a batch and the first ranks of teams."""

from __future__ import annotations

import json
import zlib
from collections.abc import Sequence

from solidwhirl.batch_journal import row_document, row_from_document
from solidwhirl.sweep_records import BatchRow

#: What a team tells.
ASK, ASK_SMALL, DONE = "ask", "ask small", "done"
ROW, LOST, ENDED = "row", "lost", "ended"
#: Tags.
FROM_TEAM, TO_TEAM = 1, 2
#: Other ranks give rank 0 so long to end all in order [s].
ENDING_S = 10.0
# Messages of so many bytes are copied at once, whether rank 0 looks or not; MPI libraries leave
# larger ones where they are until it does (Open MPI in shared memory: 4096).
_PIECE = 2048


def pieces_of(row: BatchRow | None) -> list[bytes]:
    """Return a row in pieces that MPI libraries copy at once; none of None.

    Parameters
    ----------
    row
        The row.
    """
    if row is None:
        return []
    data = zlib.compress(json.dumps(row_document(row)).encode())
    return [data[start : start + _PIECE] for start in range(0, len(data), _PIECE)]


def row_of(pieces: Sequence[bytes]) -> BatchRow:
    """Return the row that was sent in pieces.

    Parameters
    ----------
    pieces
        From `pieces_of`.
    """
    return row_from_document(json.loads(zlib.decompress(b"".join(pieces))))
