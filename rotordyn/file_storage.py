"""How a dataset is stored: what reading it would take is found out before anything is read.

A few bytes can declare gigabytes: as values never written, in chunks larger than the data, or in
compressed chunks that swell. All three are refused here.
"""

from __future__ import annotations

import zlib
from typing import Any

import h5py

# Filters that the format uses; decoders of others are not trusted with bytes from elsewhere.
_DEFLATE, _SHUFFLE, _FLETCHER32 = 1, 2, 3
_FILTERS = {_DEFLATE: "gzip", _SHUFFLE: "shuffle", _FLETCHER32: "fletcher32"}
_CHECKSUM_BYTES = 4
# Chunks: h5py makes them up to 1 MiB. What does not shrink is stored as it is, so a stored chunk
# is hardly larger than its content.
_LARGEST_CHUNK, _OVERHEAD = 1 << 24, 1 << 10
# gzip swells at most by 1032; below this a chunk may do so without a look.
_MOST_SWELLING, _HARMLESS = 1032, 1 << 24
# Memory of all numbers of a file: to begin with, and for each byte of the file.
_FIRST_BYTES, _BYTES_PER_BYTE = 1 << 26, 200
_NUMBER_BYTES = 8


def allowed_bytes(file_size: int) -> int:
    """Return how many bytes of numbers a file of some size may declare.

    Matrices of zeros shrink a thousand times, those of real bodies four times.

    Parameters
    ----------
    file_size
        Bytes of the file.
    """
    return _FIRST_BYTES + _BYTES_PER_BYTE * file_size


def declared_bytes(dataset: h5py.Dataset) -> int:
    """Return the memory of a dataset's numbers in double precision.

    Parameters
    ----------
    dataset
        Of numbers.
    """
    count = 1
    for length in dataset.shape:
        count *= int(length)
    return count * max(_NUMBER_BYTES, int(dataset.dtype.itemsize))


def storage_fault(dataset: h5py.Dataset) -> str:
    """Return why a dataset's storage is not trusted; empty if it is.

    Parameters
    ----------
    dataset
        In the file itself, of numbers or texts.
    """
    if dataset.is_virtual or dataset.external:
        return "keeps its data in another file, which is not followed"
    found = _filters(dataset)
    strange = [str(code) for code in found if code not in _FILTERS]
    if strange:
        known = ", ".join(_FILTERS.values())
        return f"is packed by HDF5 filter {', '.join(strange)}; allowed are {known}"
    if len(set(found)) < len(found):
        return "is packed twice by the same HDF5 filter"
    chunk = dataset.chunks
    if chunk is None:
        return ""
    size = int(dataset.dtype.itemsize)
    for length in chunk:
        size *= int(length)
    if size > _LARGEST_CHUNK:
        return f"has chunks of {size} bytes, at most {_LARGEST_CHUNK} are allowed"
    return _swelling(dataset, size) if _DEFLATE in found else ""


def _filters(dataset: h5py.Dataset) -> list[int]:
    plist: Any = dataset.id.get_create_plist()
    return [int(plist.get_filter(k)[0]) for k in range(plist.get_nfilters())]


def _swelling(dataset: h5py.Dataset, chunk_bytes: int) -> str:
    """Why a compressed chunk is not what it should be: it holds more than it declares."""
    skipped = 1 << _filters(dataset).index(_DEFLATE)  # in the mask of a chunk stored unpacked
    harmless = max(_HARMLESS, 2 * chunk_bytes) // _MOST_SWELLING
    for chunk in _chunks(dataset, harmless):
        if chunk.size > chunk_bytes + _OVERHEAD:
            return f"has a chunk of {chunk.size} bytes for content of {chunk_bytes}"
        if chunk.filter_mask & skipped:
            continue
        _, packed = dataset.id.read_direct_chunk(chunk.chunk_offset)
        most = chunk_bytes + _CHECKSUM_BYTES
        try:
            content = zlib.decompressobj().decompress(packed, most + 1)
        except zlib.error as error:
            return f"cannot be read: {error}"
        if len(content) > most:
            return f"has a chunk that holds more than the {chunk_bytes} bytes it declares"
    return ""


def _chunks(dataset: h5py.Dataset, harmless: int) -> list[Any]:
    """Stored chunks larger than what does no harm."""
    if dataset.id.get_storage_size() <= harmless:
        return []
    found: list[Any] = []
    if hasattr(dataset.id, "chunk_iter"):
        dataset.id.chunk_iter(found.append)
    else:  # before h5py 3.8, slower for many
        found += [dataset.id.get_chunk_info(k) for k in range(dataset.id.get_num_chunks())]
    return [chunk for chunk in found if chunk.size > harmless]
