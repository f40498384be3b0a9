"""Peak memory of commands by frame size.

    python -m tests.bench.peaks [--sizes 1920x1080 3840x2160 7680x4320] [--only info complete] [--threads 2]

The bundled sample, scaled up, is read and completed by the command line, each time in a separate process, with all
default files of `ilf complete`; or opened, extracted, run and shown in the window. Prints the peak memory of the
process [GB], bytes per pixel beyond the peak for a tiny frame, and the estimate of `memory.py` for completing a frame
of this size [GB].
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from ilf._runtime.memory import memory_needed

from .samples import size_of, write_sample

_COMMANDS = {
    "info": ("ilf", "info", "FRAME"),
    "complete": ("ilf", "complete", "FRAME", "--quiet", "--out", "OUT"),
    "complete, mesh": ("ilf", "complete", "FRAME", "--quiet", "--mesh", "ply", "--normals", "--out", "OUT"),
    "complete, paper": ("ilf", "complete", "FRAME", "--quiet", "--preset", "paper", "--out", "OUT"),
    "window": ("gui", "FRAME", "--run", "--screenshot", "OUT.png"),
}
"""Modules to run, and their arguments."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", nargs="+", default=["1920x1080", "3840x2160", "7680x4320"])
    parser.add_argument("--only", nargs="+", default=list(_COMMANDS)[:2], choices=list(_COMMANDS))
    parser.add_argument("--threads", type=int, default=2)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        usual = {name: peak(_COMMANDS[name], Path(folder), "160x120", given.threads) for name in given.only}
        print(f"{'':12} {'':16} {'peak [GB]':>10} {'bytes a pixel':>14} {'estimate [GB]':>14}")
        for size in given.sizes:
            for name in given.only:
                taken = peak(_COMMANDS[name], Path(folder), size, given.threads)
                width, height = size_of(size)
                more, estimate = (taken - usual[name]) / (width * height), memory_needed(width, height) / 1e9
                print(f"{size:12} {name:16} {taken / 1e9:10.2f} {more:14.0f} {estimate:14.2f}", flush=True)


def peak(command: tuple[str, ...], folder: Path, size: str, threads: int) -> int:
    """Return the peak memory of a command [bytes]."""
    frame = folder / size
    if not frame.exists():
        write_sample(frame, size_of(size))
    named = {"FRAME": str(frame), "OUT": str(folder / "out"), "OUT.png": str(folder / "out.png")}
    arguments = [named.get(part, part) for part in command]
    alone = {name: str(threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")} | {"ILF_MEMORY": "100"}
    child = subprocess.Popen([sys.executable, "-m", *arguments], env={**os.environ, **alone}, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    if status != 0:
        raise SystemExit(f"{' '.join(arguments)} ended with status {os.waitstatus_to_exitcode(status)}")
    return used.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


if __name__ == "__main__":
    main()
