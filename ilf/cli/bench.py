"""`ilf bench`: compare presets and peers on any set of frames."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import astuple
from functools import partial
from itertools import groupby
from operator import itemgetter

from .._runtime.formatting import counted
from .._runtime.installation import __version__
from .._runtime.schema import PROGRAM
from ..errors import InputError
from ..evaluation.bench.frames import PATTERNS, find_frames, parse_names
from ..evaluation.bench.methods import GROUPS, METHODS
from ..evaluation.bench.results import Line, Skipped, content, summarise
from ..evaluation.bench.runner import run_bench
from ..io.tables import write_csv
from ..run.record import library_versions
from .output import Bar, Column, print_json, shows_progress, table, warn
from .parsing import add_shared
from .usage import Parser, declare

_NAMES_LISTED = 6

_Table = tuple[str, Sequence[Column], Sequence[Line]]
"""Title, columns and lines of a table to print."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Hold out known depth of frames, complete it with every method, and compute the errors: over all frames, and "
        "frame by frame relative to the best peer (method other than a preset) on that frame. Hold-out pixels that a "
        "method leaves missing are scored with their nearest known depth."
    )
    declared = f"""
        FOLDER ...      folder with rgb.*, depth.* and meta.json, or folder of such folders
        --limit N       use only the first N frames
        --pattern LIST  hold-out patterns, any of {"; ".join(f"{name}: {what}" for name, what in PATTERNS.items())}
        --seed SEED     random seed, 0 or more
        --methods LIST  any of all; {"; ".join(f"{group} = {','.join(names)}" for group, names in GROUPS.items())}
        --jobs N        number of processes; more than 1 distorts the times
        --csv FILE      write the table as CSV
    """
    declare(parser, declared, pattern="random,areas", seed=0, methods="all", jobs=1)
    add_shared(parser, "--json", "--progress")


_METHOD = Column("method", itemgetter("method"))
_RMSE = Column("RMSE [mm]", itemgetter("rmse_mm"), ".2f", min)
_SECONDS = Column("seconds", itemgetter("seconds"), ".3f", min)

_MEANS = (
    _RMSE,
    Column("MAE [mm]", itemgetter("mae_mm"), ".2f", min),
    Column("median [mm]", itemgetter("median_mm"), ".2f", min),
    Column("Rel", itemgetter("rel"), ".4f", min),
    Column("delta<1.25", itemgetter("delta_1"), ".2%", max),
    Column("coverage", itemgetter("coverage"), ".2%", max),
    _SECONDS,
    Column("extraction [s]", itemgetter("extraction_seconds"), ".3f"),
)


def _beside_peers(measure: str) -> tuple[Column, ...]:
    """Return the columns of a measure: the values of a line whose names begin with it."""

    def interval(percent: int, line: Line) -> str | None:
        low, high = (line[f"{measure}_{side}_{percent}"] for side in ("low", "high"))
        return None if low is None else f"{low:.2f}-{high:.2f}"

    return (
        Column(f"{measure.upper()} [mm]", itemgetter(f"{measure}_geometric_mm"), ".2f", min),
        Column("/ peer", itemgetter(f"{measure}_ratio"), ".3f", min),
        Column("68 %", partial(interval, 68)),
        Column("95 %", partial(interval, 95)),
        Column("wins", itemgetter(f"{measure}_wins"), "d", max),
    )


_EXPECTED = (
    Column("within", itemgetter("within"), ".2%"),
    Column("within twice", itemgetter("within_twice"), ".2%"),
    Column("calibrated frames", itemgetter("calibrated"), ".1%"),
    Column("sparsification", itemgetter("sparsification"), ".4f", min),
)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    folders = find_frames(arguments.folders)[: arguments.limit]
    patterns = parse_names(arguments.pattern, PATTERNS, what="pattern")
    methods = parse_names(arguments.methods, METHODS, {"all": tuple(METHODS), **GROUPS})
    seed = arguments.seed
    with Bar(len(folders) * len(patterns), "frames and patterns", shown=shows_progress(arguments)) as bar:
        result = run_bench(folders, patterns, methods, seed, jobs=arguments.jobs, on_progress=bar.advance)
    _warn_of_skipped(result.skipped)
    warn(
        f"{row.method} failed on {row.frame}, pattern {row.pattern}, scored as nothing filled. {row.failure}"
        for row in result.rows
        if row.failure
    )
    if not result.rows:
        raise InputError("No frame could be scored, so there is nothing to compare. Check the folders.")
    lines = summarise(result)
    tables: list[_Table] = []
    for pattern, members in groupby(lines, itemgetter("pattern")):
        own = list(members)
        title = f"{pattern}: {PATTERNS[pattern]} ({counted(own[0]['frames'], 'frame')}, seed {seed})"
        beside = "frame by frame: geometric means of the error, and of its ratio to the best peer on the same frame"
        tables += [
            (title, _MEANS, own),
            (f"{pattern}, {beside}", _beside_peers("rmse") + _beside_peers("mae"), own),
            (f"{pattern}, expected error", _EXPECTED, own),
        ]
    if arguments.json:
        versions = {"program": PROGRAM, "version": __version__, "versions": library_versions()}
        print_json(versions | content(result, patterns, methods, seed))
    else:
        for number, (title, columns, shown) in enumerate(tables):
            print("\n" * bool(number) + "\n".join([title, *table([_METHOD, *columns], shown)]))
    if arguments.csv is not None:
        write_csv(arguments.csv, [list(lines[0]), *(line.values() for line in lines)])


def _warn_of_skipped(skipped: Iterable[Skipped]) -> None:
    """Warn of skipped frames, one line per reason."""
    by_reason: dict[tuple[str, str], list[str]] = {}
    for frame, pattern, reason in map(astuple, skipped):
        by_reason.setdefault((pattern, reason), []).append(frame)
    for (pattern, reason), frames in by_reason.items():
        more = f" and {len(frames) - _NAMES_LISTED} more" if len(frames) > _NAMES_LISTED else ""
        where = f" for pattern {pattern}" if pattern else ""
        warn([f"skipped{where}: {', '.join(frames[:_NAMES_LISTED])}{more}. {reason}"])
