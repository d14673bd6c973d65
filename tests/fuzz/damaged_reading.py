"""Read damaged superelement files; called in a process that may crash or grow."""

from __future__ import annotations

import random
import resource
import warnings

from superelement_damage import DAMAGES, damage_bytes, damage_content, without_seal

from solidwhirl.rotordyn import SuperelementError, read_superelement


def read_damaged(folder, kind, seed):
    """("read", "refused" or "leaked", message) of a file with the damage of a seed."""
    rng, path = random.Random(seed), folder / f"damaged_{kind}.h5"
    original = folder / rng.choice(("shaft.h5", "rigid.h5", "harmonic.h5"))
    if kind == "content":
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # about what is being made, not about reading it
            damage_content(original, path, rng, DAMAGES[seed % len(DAMAGES)])
    else:
        content = original.read_bytes()
        content = content if kind == "sealed" else without_seal(content)
        path.write_bytes(damage_bytes(content, rng))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            read_superelement(path)
        except SuperelementError as error:
            return "refused", str(error)
        except Exception as error:
            return "leaked", f"{type(error).__name__}: {error}"[:500]
    return "read", ""


def peak_mib():
    """Largest memory of this process and its children so far."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return max(resource.getrusage(kind).ru_maxrss for kind in kinds) / 1024.0
