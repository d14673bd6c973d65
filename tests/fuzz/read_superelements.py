"""Read many damaged superelement files in one process; started by the test beside it.

Arguments: folder, kind ("bytes", "sealed" or "content"), first seed, number. Each input is
announced before it is read, so that a crash or a hang names it: lines "begin <seed> <what>" and
"end <seed> <JSON: outcome, message>".
"""

from __future__ import annotations

import json
import random
import resource
import sys
import warnings
from pathlib import Path

from superelement_damage import DAMAGES, damage_bytes, damage_content, without_seal

from solidwhirl.rotordyn import SuperelementError, read_superelement


def main():
    folder, kind, first, count = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    warnings.simplefilter("error")
    originals = [folder / name for name in ("shaft.h5", "rigid.h5", "harmonic.h5")]
    contents = [original.read_bytes() for original in originals]
    copy = folder / f"damaged_{kind}.h5"
    say("memory", 0, peak_mib())
    for seed in range(first, first + count):
        rng = random.Random(seed)
        what = kind
        if kind == "content":
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # about what is being made, not about reading it
                chosen = DAMAGES[seed % len(DAMAGES)]
                what = damage_content(rng.choice(originals), copy, rng, chosen)
        else:
            content = rng.choice(contents)
            content = content if kind == "sealed" else without_seal(content)
            copy.write_bytes(damage_bytes(content, rng))
        say("begin", seed, what)
        say("end", seed, json.dumps(outcome(copy)))
    say("memory", 1, peak_mib())


def outcome(path):
    try:
        read_superelement(path)
    except SuperelementError as error:
        return ["refused", str(error)]
    except Exception as error:
        return ["leaked", f"{type(error).__name__}: {error}"[:500]]
    return ["read", ""]


def peak_mib():
    """Largest memory of this process and its children so far."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return max(resource.getrusage(kind).ru_maxrss for kind in kinds) / 1024.0


def say(*words):
    print(*words, flush=True)


if __name__ == "__main__":
    main()
