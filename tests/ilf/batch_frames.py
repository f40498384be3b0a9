"""Frames for batches: small ones in files, and one that ends whoever reads it; what a batch has written."""

import csv
import json
import os
import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
import pytest

import ilf.batch.engine
import ilf.batch.folder_sink
import ilf.batch.pictures
import ilf.batch.shard_sink
from ilf.batch.engine import Sink, complete_frame
from ilf.batch.frame_record import FrameOutcome
from ilf.batch.frames import BatchFrame
from ilf.sources.frame_ref import FrameRef

H, W = 24, 32


def write_frames(root: Path, count: int, shape: tuple[int, int] = (H, W)) -> Path:
    """Write rgb/0000.png, depth/0000.png, ...: two walls that move, and holes; returns the folder."""
    height, width = shape
    rows, columns = np.mgrid[:height, :width]
    for number in range(count):
        rng = np.random.default_rng(number)
        left = columns < width // 2 + number % 5 - 2
        colour = np.where(left[..., None], (40, 90, 200), (220, 200, 60)).astype(np.uint8)
        depth = np.where(left, 1500 + 4 * rows, 2600 + 3 * columns).astype(np.uint16)
        for _ in range(2):
            top, across = rng.integers(2, height * 3 // 4), rng.integers(2, width * 3 // 4)
            depth[top : top + height // 5, across : across + width // 5] = 0
        for folder, image in (("rgb", colour), ("depth", depth)):
            (root / folder).mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(root / folder / f"{number:04}.png"), image)
    return root


@dataclass(frozen=True)
class Deadly(FrameRef):
    """A frame that kills the process that reads it, as a library that crashes would."""

    maker: int = field(default_factory=os.getpid)

    def allowed(self) -> Self:
        if os.getpid() != self.maker:
            os.kill(os.getpid(), signal.SIGKILL)
        return self


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a batch, without what tells of time."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            content = path.read_bytes()
            if path.name == "frame.json":
                data = json.loads(content)
                data["outcome"]["seconds"] = None
                content = json.dumps(data).encode()
            if path.name == "manifest.csv":
                content = b"".join(
                    ",".join({**row, "seconds": ""}.values()).encode()
                    for row in csv.DictReader(content.decode().splitlines())
                )
            found[path.relative_to(folder).as_posix()] = content
    return found


def work_in_this_process(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Have frames completed without processes of their own; returns the keys of those that are begun."""
    begun: list[str] = []

    def apart(work: Callable[[Any], Any], items: list[Any], **_: object) -> Iterator[tuple[Any, Any]]:
        for item in items:
            yield item, work(item)

    def completed(sink: Sink, frame: BatchFrame, threads: int | None = None) -> FrameOutcome:
        begun.append(frame.key)
        return complete_frame(sink, frame, threads)

    for module in (ilf.batch.engine, ilf.batch.folder_sink, ilf.batch.pictures, ilf.batch.shard_sink):
        monkeypatch.setattr(module, "run_in_processes", apart)
    monkeypatch.setattr(ilf.batch.engine, "complete_frame", completed)
    return begun
