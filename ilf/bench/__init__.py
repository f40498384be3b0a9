"""The bench: presets and peers complete the same frames with depth hidden, and are scored on what was hidden."""

from .frames import BenchFrame, find_frames, load_bench_frame
from .methods import METHODS, Method, choose_methods
from .patterns import PATTERNS, Task, make_task
from .results import Summary, summarise, write_csv, write_json
from .runner import BenchResult, Plan, Row, Skipped, run_bench
from .scoring import Score, score

__all__ = [
    "METHODS",
    "PATTERNS",
    "BenchFrame",
    "BenchResult",
    "Method",
    "Plan",
    "Row",
    "Score",
    "Skipped",
    "Summary",
    "Task",
    "choose_methods",
    "find_frames",
    "load_bench_frame",
    "make_task",
    "run_bench",
    "score",
    "summarise",
    "write_csv",
    "write_json",
]
