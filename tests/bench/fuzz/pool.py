"""Supervised child processes that read files: crashes and hangs are recorded, and the child is replaced."""

from __future__ import annotations

import json
import queue
import signal
import subprocess
import sys
import tempfile
import threading
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SECONDS = 10.0
"""Time limit for one file [s]."""

_START_S = 120.0


@dataclass
class Tally:
    """Results of the cases of one format.

    Attributes
    ----------
    kinds : Counter
        "ok", "told" (an error of the library in one line), "traceback", "memory", "crash", "hang".
    bad : list of (int, str, str)
        Number of the case, kind and what happened, of all but "ok" and "told".
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
    child = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert child.stdout is not None
    lines: queue.Queue[dict[str, Any] | None] = queue.Queue()
    reader = threading.Thread(target=_pass_on, args=(child.stdout, lines), daemon=True)
    errors: list[bytes] = []
    assert child.stderr is not None
    listener = threading.Thread(target=lambda stream: errors.append(stream.read()), args=(child.stderr,), daemon=True)
    reader.start()
    listener.start()
    is_ready = False
    try:
        while first < last:
            line = lines.get(timeout=SECONDS if is_ready else _START_S)
            if line is None:
                status = child.wait()
                listener.join()
                if not is_ready or status > 0:
                    raise SystemExit(f"{name}: the child ended unexpectedly ({status}): {errors[0].decode()[-2000:]}")
                tally.add(first, "crash", signal.Signals(-status).name)
                return first + 1
            is_ready = True
            if "case" in line:
                tally.add(line["case"], line["kind"], line["what"])
                tally.slowest = max(tally.slowest, line["seconds"])
                first = line["case"] + 1
        line = lines.get(timeout=SECONDS)
        tally.peak = max(tally.peak, line["peak"] if line else 0)
    except queue.Empty:
        tally.add(first, "hang", f"more than {SECONDS:g} s")
        first += 1
    finally:
        child.kill()
        child.wait()
        reader.join()
        listener.join()
        child.stdout.close()
        child.stderr.close()
    return first


def _pass_on(stream: Any, lines: queue.Queue[dict[str, Any] | None]) -> None:
    for line in stream:
        lines.put(json.loads(line))
    lines.put(None)
