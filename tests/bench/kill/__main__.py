"""Test of recovery: the window is killed with -9 at random moments, many times, and the recovered work is checked.

    QT_QPA_PLATFORM=offscreen python -m tests.bench.kill [--rounds 100] [--seed 0] [--ends]

A child process works randomly in the real window (strokes, splits, names, locks, values, runs, undo, other frames,
saving the project) and reports the state of all frames after each step. It is killed at any moment, or while it writes
its autosave or the project file. Autosave and project file must contain a state that the child has had, the last one or
one that was replaced at most 3 s before the kill, with all frames from the same moment. The exit status is 1 if they
do not.
"""

import argparse
import tempfile
from pathlib import Path

import numpy as np

from .rounds import ENDS, LATEST_S, MOMENTS, frames_in, one_round


def main() -> None:
    """Kill, and print a summary of the recovered work."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--ends", action="store_true", help="kill while it saves, exports all frames, or closes")
    options = parser.parse_args()
    ages, states, opened, wrong, moments = [], 0, 0, [], {}
    with tempfile.TemporaryDirectory() as folder:
        frames = frames_in(Path(folder))
        for number in range(options.seed, options.seed + options.rounds):
            found = one_round(number, frames, Path(folder, str(number)), moments=ENDS if options.ends else MOMENTS)
            print(found, flush=True)
            states += found.states
            opened += found.project_opened
            moments[found.moment] = moments.get(found.moment, 0) + 1
            if found.age is not None:
                ages.append(found.age)
            if found.problem or (found.age or 0.0) > LATEST_S:
                wrong.append(found)
    print(f"{options.rounds} kills ({', '.join(f'{count} at {name}' for name, count in sorted(moments.items()))})")
    print(f"{states} states, {len(ages)} recovered, {opened} project files opened, {len(wrong)} wrong")
    if ages:
        middle, high = np.percentile(ages, [50, 95])
        print(f"age of the recovered state [s]: median {middle:.3f}, 95 % {high:.3f}, maximum {max(ages):.3f}")
    for found in wrong:
        print(found)
    raise SystemExit(any(found.problem for found in wrong))


if __name__ == "__main__":
    main()
