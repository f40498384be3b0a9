"""How good depth is: against a truth or against depth that is hidden, for one run, several, or a range of values."""

from .against_truth import TruthResult, truth_steps
from .comparing import compared_steps
from .expectation import share_within, sparsification_error
from .hidden import HiddenResult, HiddenTest, compare_hidden, comparison_steps, hidden_steps, judge_hidden
from .hiding import HIDDEN_PATTERNS, hidden_pixels
from .judged import Judged, PixelErrors, RunJudged
from .judging import Judgement, judge, judge_blocks, judge_completion
from .shared_pixels import shared_pixels
from .step import Step
from .sweep import Sweep, SweepPoint, SweepResult, run_sweep, sweep_steps

__all__ = [
    "HIDDEN_PATTERNS",
    "HiddenResult",
    "HiddenTest",
    "Judged",
    "Judgement",
    "PixelErrors",
    "RunJudged",
    "Step",
    "Sweep",
    "SweepPoint",
    "SweepResult",
    "TruthResult",
    "compare_hidden",
    "compared_steps",
    "comparison_steps",
    "hidden_pixels",
    "hidden_steps",
    "judge",
    "judge_blocks",
    "judge_completion",
    "judge_hidden",
    "run_sweep",
    "share_within",
    "shared_pixels",
    "sparsification_error",
    "sweep_steps",
    "truth_steps",
]
