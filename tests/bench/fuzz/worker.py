"""Child process that reads the cases of one format in turn, within limits, and prints a line of JSON for each.

python -m tests.bench.fuzz.worker FORMAT SEED FIRST LAST FOLDER [KEEP]
"""

import json
import os
import re
import resource
import signal
import sys
import time
import traceback
import warnings
import zlib
from pathlib import Path
from typing import TextIO

import cv2
import numpy as np

from ilf._runtime import children
from ilf.errors import DepthWarning, IlfError

from .formats import FORMATS, Format

MEMORY = 4 * 2**30
PEAK = 10**9
"""Limits of the address space, and of the memory that is really used [bytes]."""
SECONDS, END = 10, 100
"""Longest time for a file [s], and time after which the process is ended."""
LONGEST_MESSAGE = 2000


def case(form: Format, seeds: list[bytes], seed: int, number: int) -> bytes:
    """Make the file of a case, always the same for the same numbers."""
    return form.mutate(np.random.default_rng([seed, zlib.crc32(form.name.encode()), number]), seeds)


def outcome(form: Format, path: Path) -> tuple[str, str]:
    """Read a file and return the result: "ok", "told", or "traceback", and where."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", DepthWarning)
            form.read(path)
    except IlfError as error:
        text = str(error)
        if "\n" in text or not text or len(text) > LONGEST_MESSAGE:
            return "traceback", f"message of {text.count(chr(10)) + 1} lines, {len(text)} characters: {text[:200]!r}"
        return "told", text
    except MemoryError:
        return "memory", _where()
    except Exception as error:
        return "traceback", f"{type(error).__name__} {_where()}: {str(error)[:200]}"
    return "ok", ""


def _where() -> str:
    """The last line of the project in a traceback."""
    frames = traceback.extract_tb(sys.exc_info()[2])
    own = [frame for frame in frames if f"{os.sep}ilf{os.sep}" in frame.filename] or frames
    return f"{Path(own[-1].filename).name}:{own[-1].lineno}"


def sound_files(form: Format, place: Path) -> list[bytes]:
    """Make the valid files of a format and their companion files in an empty folder, and read them."""
    for name in ("MODELS", "PRESETS", "AUTOSAVE", "FOLDERS"):
        os.environ[f"ILF_{name}"] = str(place / name)
    path = place / form.file
    seeds = form.seeds(place) or [path.read_bytes()]
    path.parent.mkdir(parents=True, exist_ok=True)
    for number, sound in enumerate(seeds):
        path.write_bytes(sound)
        found = outcome(form, path)
        if found[0] != "ok":
            raise SystemExit(f"{form.name}: seed {number} cannot be read: {found}")
    return seeds


def work(form: Format, seed: int, first: int, last: int, place: Path, keep: Path | None, out: TextIO) -> None:
    """Read the cases from `first` up to, not including, `last`, in an empty folder."""
    seeds, path = sound_files(form, place), place / form.file
    print(json.dumps({"ready": len(seeds)}), file=out, flush=True)
    for number in range(first, last):
        content = case(form, seeds, seed, number)
        path.parent.mkdir(parents=True, exist_ok=True)  # an autosave without work is removed
        path.unlink(missing_ok=True)  # otherwise some file systems wait for the disk
        path.write_bytes(content)
        del content
        _forget_peak()
        begun = time.perf_counter()
        signal.alarm(END)
        kind, what = outcome(form, path)
        signal.alarm(0)
        took = time.perf_counter() - begun
        if took > SECONDS:
            kind, what = "hang", f"more than {SECONDS} s, then {kind}: {what}"
        elif _peak() > PEAK:
            kind, what = "memory", f"more than {PEAK / 1e6:.0f} MB, {kind}: {what}"
        if keep is not None and kind not in {"ok", "told"}:
            (keep / f"{form.name}-{number}{path.suffix}").write_bytes(case(form, seeds, seed, number))
        line = {"case": number, "kind": kind, "what": what if kind != "ok" else "", "seconds": took}
        print(json.dumps(line), file=out, flush=True)
        if kind == "memory":
            break
    children.end(children._idle)
    print(json.dumps({"peak": _peak()}), file=out, flush=True)


def _forget_peak() -> None:
    """Let the maximum memory of this process begin anew: making a file may have taken more than reading it does."""
    Path("/proc/self/clear_refs").write_text("5")


def _peak() -> int:
    """Maximum memory of this process, or of a child that has ended [bytes]."""
    own = re.search(r"VmHWM:\s*(\d+) kB", Path("/proc/self/status").read_text())
    assert own is not None
    return max(int(own[1]), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss) * 1024


def main() -> None:
    """Read the requested cases; output of libraries is discarded."""
    name, *numbers = sys.argv[1:5]
    place, keep = Path(sys.argv[5]), Path(sys.argv[6]) if len(sys.argv) > 6 else None
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    cv2.setNumThreads(1)
    form = FORMATS[name]
    children.set_process_limits(3600 * 24, MEMORY)
    work(form, *map(int, numbers), place, keep, out)


if __name__ == "__main__":
    main()
