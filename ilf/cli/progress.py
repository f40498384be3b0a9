"""Progress bars: of a run, and of judging several."""

from __future__ import annotations

from types import TracebackType
from typing import Any, Self

from tqdm import tqdm

from ..judgement import Step
from ..outcomes import Progress
from ..run import GUESS, RunSteps


class Bar(tqdm):
    """tqdm without its monitor thread."""

    # otherwise the first bar starts a thread that outlives it
    monitor_interval = 0


class FramesBar(Bar):
    """A bar of a batch's frames on stderr, as long as the context lasts. The time left follows from the frames
    completed in this time: those that failed, or were there before, took hardly any.

    Parameters
    ----------
    total, done, failed : int
        Frames in all; those that come to nothing new, and how many of these failed before.
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, total: int, done: int, failed: int, *, shown: bool) -> None:
        self.completed, self.failed = 0, failed
        super().__init__(
            total=total,
            initial=done,
            disable=not shown,
            mininterval=0,
            leave=False,
            dynamic_ncols=True,
            bar_format="{n_fmt}/{total_fmt} frames |{bar:30}| {elapsed}, {left} left{postfix}",
        )

    def add(self, *, completed: bool) -> None:
        """One frame more is completed, or has failed."""
        self.completed += completed
        self.failed += not completed
        self.set_postfix_str(f"{self.failed} failed" if self.failed else "", refresh=False)
        self.update(1)

    @property
    def format_dict(self) -> dict[str, Any]:
        """What there is for the bar to show."""
        known: dict[str, Any] = super().format_dict
        left = self.total - self.n
        known["left"] = self.format_interval(known["elapsed"] * left / self.completed) if self.completed else "?"
        return known


class _Shown:
    """A bar on stderr, as long as the context lasts; none at all unless it is shown."""

    def __init__(self, total: float, count: str, shown: bool) -> None:
        self._bar = Bar(
            total=total,
            disable=not shown,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format=count + " |{bar:30}| {elapsed}{postfix}",
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.close()


class RunProgress(_Shown):
    """A bar on stderr: blocks done, and the last iteration of a block that runs.

    Parameters
    ----------
    run : RunSteps
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, run: RunSteps, *, shown: bool) -> None:
        super().__init__(len(run.blocks), "{n_fmt}/{total_fmt} blocks", shown)

    def update(self, step: Progress) -> None:
        """Show a step of the run."""
        record = step.record
        if record is None:
            self._bar.update(step.result is not None)
            return
        what = "guessing the rest" if step.label == GUESS else f"block {step.label}"
        self._bar.set_postfix_str(
            f"{what}: iteration {record.i}, stage {record.stage}, sigma {record.sigma_i * 1000:.3g} mm",
            refresh=False,
        )
        self._bar.update(0)


class ShareProgress(_Shown):
    """A bar on stderr for what tells the share that is done and what is under way.

    Parameters
    ----------
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, *, shown: bool) -> None:
        super().__init__(1.0, "{percentage:3.0f} %", shown)

    def update(self, step: Step) -> None:
        """Show a step."""
        self._bar.set_postfix_str(step.text, refresh=False)
        self._bar.update(max(min(step.share, 1.0) - self._bar.n, 0.0))
