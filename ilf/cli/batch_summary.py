"""What `ilf batch` tells of its frames: progress and warnings as they are completed, a summary, and what has failed."""

from __future__ import annotations

import sys
from collections import Counter
from statistics import median

from .._runtime.formatting import counted, millimetres
from ..batch.engine import Sink
from ..batch.frame_record import FrameOutcome
from ..completion.confidence.expected_error import MEDIAN_NAME
from ..errors import IlfError
from ..io.depth_doubts import unique_warnings
from .output import Bar, warn

_MAX_LISTED = 5
"""Maximum number of failed frames listed on the terminal."""


_ENDS = "completed", "failed", "completed_before", "failed_before", "not_done"


class BatchSummary:
    """Sums over the frames of a batch, which may be a million.

    Parameters
    ----------
    sink : Sink
        What the frames go to.
    listed_in : str
        Where all frames are listed.
    """

    def __init__(self, sink: Sink, listed_in: str) -> None:
        self._counts, self._listed_in = sink.counts, listed_in
        self._sums: Counter[str] = Counter()
        self._errors: list[float] = []
        self._warnings: set[str] = set()
        self._failures: list[str] = []
        for outcome in sink.earlier:
            self._note(outcome)

    def add(self, outcome: FrameOutcome) -> None:
        """Add the outcome of a frame."""
        with Bar.external_write_mode(sys.stderr):
            self._note(outcome)
        if outcome.is_completed:
            names = "pixels", "missing_before", "missing_after", "outside_view"
            self._sums.update({name: getattr(outcome, name) or 0 for name in names})
            if outcome.expected_error_median_m is not None:
                self._errors.append(outcome.expected_error_median_m)

    def _note(self, outcome: FrameOutcome) -> None:
        """Print plausibility warnings, each once with the first frame that it concerns, and note a failure."""
        if outcome.plausibility_warnings:
            self._sums["implausible"] += outcome.is_completed
            new = unique_warnings([outcome.plausibility_warnings], self._warnings)
            warn(f"{outcome.frame}: {text}" for text in new)
        if not outcome.is_completed and len(self._failures) < _MAX_LISTED:
            self._failures.append(f"{outcome.frame}: {outcome.message}")

    def numbers(self) -> dict[str, int]:
        """Return the numbers of frames, by how they have ended."""
        return {name: self._counts[name] for name in _ENDS}

    def lines(self, seconds: float) -> list[str]:
        """Describe the frames of a batch that took so many seconds."""
        counts, sums = self._counts, self._sums
        parts = [
            f"{number} {what.replace('_', ' ')}"
            for what, number in self.numbers().items()
            if number or what in _ENDS[:2]
        ]
        rate = f" ({counts['completed'] / seconds:.2g} frames per second)" if counts["completed"] else ""
        lines = [f"{counted(counts.total(), 'frame')}: {', '.join(parts)}, in {seconds:.0f} s{rate}."]
        if counts["not_done"]:
            lines.append("Run the same command again to resume.")
        if sums["pixels"]:
            before, after, outside = (
                sums[name] / sums["pixels"] for name in ("missing_before", "missing_after", "outside_view")
            )
            lines.append(f"Missing depth: {before:.1%} of the pixels before, {after:.1%} after.")
            if outside:
                lines.append(f"Another {outside:.1%} lie outside the depth camera's view.")
        if sums["implausible"]:
            implausible = f"{counted(sums['implausible'], 'frame')} with plausibility warnings"
            lines.append(f"{implausible}, listed in {self._listed_in}. With --strict such frames fail.")
        if self._errors:
            lines.append(f"{MEDIAN_NAME}: {millimetres(median(self._errors))} mm in the median frame.")
        return lines

    def check_failures(self) -> None:
        """Raise IlfError if frames have failed."""
        number = self._counts["failed"] + self._counts["failed_before"]
        if not number:
            return
        told = [f"{number} of {counted(self._counts.total(), 'frame')} failed.", *self._failures]
        if hidden := number - len(self._failures):
            what = f"And {hidden} more are" if self._failures else "They are"
            told.append(f"{what} listed in {self._listed_in} (column message).")
        raise IlfError(" ".join(filter(None, [*told, "Retry them with --retry-failed."])))
