"""Child processes that read files: crashes and hangs are recorded, and another child goes on."""

import json
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Tally:
    """Results of the cases of one format.

    Attributes
    ----------
    kinds : Counter
        "ok", "told" (an error of the library in one line), "traceback", "memory", "crash", "hang".
    bad : list of (int, str, str)
        Number of the case, kind and what happened, of all but "ok" and "told".
    told : Counter
        Messages of "told".
    slowest : float
        Longest time of a case [s].
    peak : int
        Maximum memory of a child [bytes].
    """

    kinds: Counter[str] = field(default_factory=Counter)
    bad: list[tuple[int, str, str]] = field(default_factory=list)
    told: Counter[str] = field(default_factory=Counter)
    slowest: float = 0.0
    peak: int = 0

    def add(self, number: int, kind: str, what: str) -> None:
        """Count a case."""
        self.kinds[kind] += 1
        if kind == "told":
            self.told[what] += 1
        elif kind != "ok":
            self.bad.append((number, kind, what))


def read_cases(name: str, seed: int, first: int, last: int, keep: Path | None) -> Tally:
    """Read the cases from `first` up to, not including, `last` of a format, by as many children as needed."""
    tally = Tally()
    while first < last:
        with tempfile.TemporaryDirectory(prefix="ilf-fuzz-") as place:
            first = _one_child(name, seed, first, last, place, keep, tally)
    return tally


def _one_child(name: str, seed: int, first: int, last: int, place: str, keep: Path | None, tally: Tally) -> int:
    """Run one child; return the number of the first case of the next child."""
    words = [sys.executable, "-m", "tests.bench.fuzz.worker", name, str(seed), str(first), str(last), place]
    words += [str(keep)] if keep else []
    child = subprocess.run(words, capture_output=True, text=True, errors="replace", check=False)
    lines = [json.loads(line) for line in child.stdout.splitlines()]
    for line in lines:
        if "case" in line:
            tally.add(line["case"], line["kind"], line["what"])
            tally.slowest = max(tally.slowest, line["seconds"])
            first = line["case"] + 1
        tally.peak = max(tally.peak, line.get("peak", 0))
    if child.returncode == 0:
        return first
    if not lines or child.returncode > 0:
        told = f"after {dict(tally.kinds)} the child ended unexpectedly ({child.returncode})"
        raise SystemExit(f"{name}: {told}: {tally.bad} {child.stderr[-2000:]}")
    ended_by = signal.Signals(-child.returncode).name
    tally.add(first, "hang" if ended_by == "SIGALRM" else "crash", ended_by)
    return first + 1
