"""Kill runs at moments spread over their length, run again, and print what was found as JSON.

killed.py SCENE FOLDER COUNT SEED [OPTION ...]
"""

from __future__ import annotations

import json
import random
import shutil
import signal
import sys
import time
from pathlib import Path

from forked import Run, differences, leftovers, numbers, problems, stages


def campaign(scene, folder, count, seed, options):
    """Kill `count` runs; the first half of the moments in an empty folder, then over old results.

    Moments lie in equal parts of the time that an undisturbed run takes, and a little beyond.
    """
    length = []
    for name in ("whole", "again"):
        start = time.monotonic()
        assert Run(scene, folder / name, *options).end() == 0
        length.append(time.monotonic() - start)
    length = min(length)  # other programs take their time, now more and now less
    expected = numbers(folder / "whole")
    older = folder / "older"
    assert Run(scene, older, "--accuracy", "0.09", *options).end() == 0
    old = numbers(older)
    assert old != expected
    shutil.rmtree(older / ".stages")
    chance = random.Random(seed)
    order = list(range(count))
    chance.shuffle(order)
    return [
        {
            "length_s": length,
            **_one(scene, folder / str(n), older, (expected, old), moment, n, options),
        }
        for n, part in enumerate(order)
        for moment in [1.02 * length * (part + chance.random()) / count]
    ]


def _one(scene, out, older, known, moment_s, number, options):
    expected, old = known
    over_old = number % 2 == 1
    if over_old:
        shutil.copytree(older, out)
    code = Run(scene, out, *options).signal_after(moment_s, signal.SIGKILL)
    left = numbers(out)
    good = not problems(out)
    before = len(list(out.glob(".stages/*.stage")))
    again = Run(scene, out, *options)
    second = again.end()
    found = {
        "moment_s": moment_s,
        "killed": code == -signal.SIGKILL,
        "over_old": over_old,
        # a folder that passes its check holds one run, whole
        "called_good": good,
        "good_is_whole": not good or left in ([expected] if not over_old else [expected, old]),
        "stages_left": before,
        "code": second,
        "damaged": "damaged" in again.said(),
        "differs": list(differences(numbers(out), expected))[:5],
        "problems": problems(out),
        "leftovers": leftovers(out),
        "kept": stages(out).count("kept") if second == 0 else -1,
        "said": again.said() if second else "",
    }
    shutil.rmtree(out)
    return found


if __name__ == "__main__":
    scene, folder, count, seed, *options = sys.argv[1:]
    print(json.dumps(campaign(Path(scene), Path(folder), int(count), int(seed), options)))
