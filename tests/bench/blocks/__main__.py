"""Quality of the operation blocks of several methods, by the frames' own known depth.

python -m tests.bench.blocks FOLDER ... [--methods canny,network] [--limit N]

No depth is held out: methods that use depth get the depth that they are scored with, as they do when the frame is
completed. Values are means over the frames that have one; seconds are medians. `watertight` is the share of the frames
without a leak. A method that fails on a frame has no blocks there.
"""

import argparse
import statistics
from collections.abc import Sequence
from operator import itemgetter
from pathlib import Path

import numpy as np

from ilf.cli.output import Column, table
from ilf.errors import IlfError
from ilf.evaluation.bench.frames import find_frames, load_bench_frame, parse_names
from ilf.evaluation.bench.results import Line, mean
from ilf.evaluation.bench.runner import timed

from .measures import find_reference, score_blocks
from .methods import BLOCK_METHODS

COLUMNS = (
    Column("method", itemgetter("method")),
    Column("coverage", itemgetter("coverage"), ".2%", max),
    Column("of frame", itemgetter("frame_coverage"), ".2%", max),
    Column("recoverable", itemgetter("recoverable"), ".2%", max),
    Column("watertight", itemgetter("watertight"), ".1%", max),
    Column("purity", itemgetter("purity"), ".2%", max),
    Column("cut rate", itemgetter("cut_rate"), ".2%", min),
    Column("recall", itemgetter("recall"), ".4f", max),
    Column("precision", itemgetter("precision"), ".4f", max),
    Column("F", itemgetter("f"), ".4f", max),
    Column("blocks", itemgetter("blocks"), ".1f"),
    Column("seconds", itemgetter("seconds"), ".3f", min),
)


def scores(folder: Path, methods: Sequence[str]) -> list[Line]:
    """Score every method on a frame; nothing for a frame that cannot be read."""
    try:
        frame = load_bench_frame(folder).frame
    except IlfError as error:
        print(f"skipped: {folder.name}. {error}")
        return []
    evidence, rows = find_reference(frame), []
    for method in methods:
        empty = np.zeros(frame.shape, np.int32)
        labels, seconds, failure = timed(lambda name=method: BLOCK_METHODS[name](frame), empty)
        if failure:
            print(f"{method} failed on {frame.name}: {failure}")
        rows.append({"method": method, "seconds": seconds} | score_blocks(labels, evidence))
    return rows


def summarised(rows: Sequence[Line]) -> list[Line]:
    """Return one line per method, the highest boundary F first."""
    lines = []
    for method in dict.fromkeys(row["method"] for row in rows):
        own = [row for row in rows if row["method"] == method]
        means = {name: mean(row[name] for row in own) for name in own[0] if name not in {"method", "seconds"}}
        watertight = mean(row["leaks"] == 0 for row in own)
        seconds = statistics.median(row["seconds"] for row in own)
        lines.append({"method": method, **means, "watertight": watertight, "seconds": seconds})
    return sorted(lines, key=lambda line: -1.0 if line["f"] is None else line["f"], reverse=True)


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.bench.blocks", description=__doc__.splitlines()[0])
    parser.add_argument("folders", nargs="+", help="folders of frames, or folders of such folders")
    parser.add_argument("--methods", default="all", help=f"any of all, {', '.join(BLOCK_METHODS)}")
    parser.add_argument("--limit", type=int, help="only the first frames")
    arguments = parser.parse_args()
    methods = parse_names(arguments.methods, BLOCK_METHODS, {"all": tuple(BLOCK_METHODS)})
    folders = find_frames(arguments.folders)[: arguments.limit]
    rows = [row for folder in folders for row in scores(folder, methods)]
    print(*table(COLUMNS, summarised(rows)), sep="\n")


if __name__ == "__main__":
    main()
