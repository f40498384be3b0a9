"""What `ilf batch` tells of its frames: progress and warnings as they are completed, a summary, and what has failed."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from statistics import median
from typing import Any

from .._runtime.formatting import counted, millimetres
from ..batch.engine import Counts
from ..batch.frame_record import FrameOutcome
from ..completion.confidence.expected_error import MEDIAN_NAME
from ..errors import IlfError
from ..io.depth_doubts import unique_warnings
from .output import Bar, warn

_MAX_LISTED = 5
"""Maximum number of failed frames listed on the terminal."""


_ALWAYS = "completed", "failed"
"""What is told of the frames even if there are none."""


class BatchSummary:
    """Sums over the frames of a batch, which may be a million.

    Parameters
    ----------
    counts : Counts
        Those of the batch.
    listed_in : str
        Where all frames are listed.
    """

    def __init__(self, counts: Counts, listed_in: str) -> None:
        self._counts, self._listed_in = counts, listed_in
        self._sums: Counter[str] = Counter()
        self._errors: list[float] = []
        self._implausible = self._more_failed = 0
        self._warnings: set[str] = set()
        self._failures: list[str] = []

    def add_earlier(self, finished: Sequence[FrameOutcome], failed: Sequence[FrameOutcome], strict: bool) -> None:
        """Add the outcomes of frames that were done before; if strict, those with plausibility warnings have failed."""
        for outcome in finished:
            self._warn(outcome)
            if strict and outcome.plausibility_warnings:
                self._more_failed += 1
                self._add_failure(outcome, outcome.plausibility_warnings)
        for outcome in failed:
            self._add_failure(outcome, outcome.message)

    def add(self, outcome: FrameOutcome) -> None:
        """Add the outcome of a frame."""
        with Bar.external_write_mode(sys.stderr):
            self._warn(outcome)
        if not outcome.is_completed:
            self._add_failure(outcome, outcome.message)
            return
        for name in ("pixels", "missing_before", "missing_after", "outside_view"):
            self._sums[name] += getattr(outcome, name) or 0
        if outcome.expected_error_median_m is not None:
            self._errors.append(outcome.expected_error_median_m)

    def lines(self, seconds: float) -> list[str]:
        """Describe the frames of a batch that took so many seconds."""
        counts, sums = self._counts, self._sums
        numbers = self._numbers()
        parts = [f"{numbers[what]} {what.replace('_', ' ')}" for what in numbers if numbers[what] or what in _ALWAYS]
        rate = f" ({counts.completed / seconds:.2g} frames per second)" if counts.completed else ""
        lines = [f"{counted(counts.total, 'frame')}: {', '.join(parts)}, in {seconds:.0f} s{rate}."]
        if counts.left:
            lines.append("Run the same command again to resume.")
        if sums["pixels"]:
            before, after = sums["missing_before"] / sums["pixels"], sums["missing_after"] / sums["pixels"]
            lines.append(f"Missing depth: {before:.1%} of the pixels before, {after:.1%} after.")
        if sums["outside_view"]:
            outside = sums["outside_view"] / sums["pixels"]
            lines.append(f"Another {outside:.1%} lie outside the depth camera's view.")
        if self._implausible:
            implausible = f"{counted(self._implausible, 'frame')} with plausibility warnings"
            lines.append(f"{implausible}, listed in {self._listed_in}. With --strict such frames fail.")
        if self._errors:
            lines.append(f"{MEDIAN_NAME}: {millimetres(median(self._errors))} mm in the median frame.")
        return lines

    def as_json(self, seconds: float) -> dict[str, Any]:
        """Return the numbers of frames for JSON."""
        return {**self._numbers(), "seconds": seconds}

    def _numbers(self) -> dict[str, int]:
        counts = self._counts
        before = {"completed_before": counts.before, "failed_before": counts.failed_before}
        return {"completed": counts.completed, "failed": counts.failed, **before, "not_done": counts.left}

    def check_failures(self) -> None:
        """Raise IlfError if frames have failed."""
        number = self._counts.failed + self._counts.failed_before + self._more_failed
        if not number:
            return
        told = [f"{number} of {counted(self._counts.total, 'frame')} failed.", "; ".join(self._failures)]
        if hidden := number - len(self._failures):
            what = f"And {hidden} more are" if self._failures else "They are"
            told.append(f"{what} listed in {self._listed_in} (column message).")
        raise IlfError(" ".join(filter(None, [*told, "Retry them with --retry-failed."])))

    def _warn(self, outcome: FrameOutcome) -> None:
        """Print plausibility warnings, each once with the first frame that it concerns."""
        if outcome.plausibility_warnings:
            self._implausible += outcome.is_completed
            warn(
                f"{outcome.frame}: {text}" for text in unique_warnings([outcome.plausibility_warnings], self._warnings)
            )

    def _add_failure(self, outcome: FrameOutcome, message: str) -> None:
        if len(self._failures) < _MAX_LISTED:
            self._failures.append(f"{outcome.frame}: {message}")
