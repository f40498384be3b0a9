"""A run, step by step, with the share that is done."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ..outcomes import Completion
from ..run import Run
from .step import Step


def completion_steps(run: Run, threads: int | None) -> Generator[Step, None, Completion]:
    """Complete a run's blocks, a step per iteration of one of them; returns what they come to."""
    with run.steps(threads) as steps:
        sizes = {label: int(np.count_nonzero(block.mask)) for label, block in steps.blocks.items()}
        total, done = max(sum(sizes.values()), 1), 0
        for progress in steps:
            if progress.result is not None:
                done += sizes[progress.label]
            yield Step(done / total, f"{len(steps.results)} of {len(sizes)} blocks")
        return steps.completion()
