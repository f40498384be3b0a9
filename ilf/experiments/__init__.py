"""The paper's experiments: run, drawn, written, and reported beside what the paper says."""

from .experiment import Comparison, Drawing, Experiment, Progress, Result, Row, Settings
from .files import read_result, rendered, write_result
from .registry import EXPERIMENTS, chosen_experiments, run_experiment
from .report import write_report

__all__ = [
    "EXPERIMENTS",
    "Comparison",
    "Drawing",
    "Experiment",
    "Progress",
    "Result",
    "Row",
    "Settings",
    "chosen_experiments",
    "read_result",
    "rendered",
    "run_experiment",
    "write_report",
    "write_result",
]
