"""The benches: completion, scored on depth that was hidden, and blocks, measured on the depth that is known."""

from .block_measures import BlockScore, score_blocks
from .block_methods import BLOCK_METHODS, BlockMethod, choose_block_methods
from .block_results import BlockSummary, summarise_blocks
from .block_runner import BlockBenchResult, BlockPlan, BlockRow, run_block_bench
from .earlier import EarlierRows, read_earlier
from .evidence import Evidence, find_evidence
from .frames import BenchFrame, find_frames, load_bench_frame
from .methods import METHODS, Method, choose_methods
from .patterns import PATTERNS, Task, make_task
from .results import Summary, summarise, write_csv, write_json
from .rows import BenchResult, Plan, Row, Skipped, TaskFacts
from .runner import run_bench
from .scoring import Score, score

__all__ = [
    "BLOCK_METHODS",
    "METHODS",
    "PATTERNS",
    "BenchFrame",
    "BenchResult",
    "BlockBenchResult",
    "BlockMethod",
    "BlockPlan",
    "BlockRow",
    "BlockScore",
    "BlockSummary",
    "EarlierRows",
    "Evidence",
    "Method",
    "Plan",
    "Row",
    "Score",
    "Skipped",
    "Summary",
    "Task",
    "TaskFacts",
    "choose_block_methods",
    "choose_methods",
    "find_evidence",
    "find_frames",
    "load_bench_frame",
    "make_task",
    "read_earlier",
    "run_bench",
    "run_block_bench",
    "score",
    "score_blocks",
    "summarise",
    "summarise_blocks",
    "write_csv",
    "write_json",
]
