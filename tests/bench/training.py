"""`python -m tests.bench.training [--items 60]`: reading items for training, in processor time per item.

Frames of 640 x 480 (the sample, shifted), their results in folders and in shards with colour: all fields of an item,
and decoding its images by OpenCV and numpy alone, in one thread. With PyTorch, also a DataLoader with two workers, all
processes together, and the memory of a worker.
"""

from __future__ import annotations

import argparse
import os
import resource
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from ilf._runtime.installation import asset_path
from ilf.cli import main as run_command
from ilf.run.frame_arrays import FrameArrays
from ilf.sources.shards import Shards

from .batch import resident

COUNT = 6
CAMERA = ["--intrinsics", "525,525,319.5,239.5", "--quiet"]
KEEP = ("rgb", "depth", "expected_error", "unsupported")


def write(root: Path) -> None:
    """Write frames, results and shards."""
    room = asset_path("samples/room")
    for folder, name in (("rgb", "rgb.jpg"), ("depth", "depth.png")):
        (root / "frames" / folder).mkdir(parents=True)
        image = cv2.imread(str(room / name), cv2.IMREAD_UNCHANGED)
        for number in range(COUNT):
            cv2.imwrite(str(root / "frames" / folder / f"{number:04}.png"), np.roll(image, 16 * number, axis=1))
    command = ["batch", str(root / "frames"), *CAMERA]
    run_command([*command, "--out", str(root / "folders"), "--no-cloud"])
    run_command([*command, "--shards", str(root / "shards"), "--keep", ",".join(KEEP)])


def milliseconds(work: Callable[[int], object], items: int) -> float:
    """Processor time of one item: the least of five repetitions."""
    found = []
    for _ in range(5):
        start = time.process_time()
        for number in range(items):
            work(number % COUNT)
        found.append((time.process_time() - start) / items * 1000)
    return min(found)


def decoded(data: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)


def decoders(root: Path) -> dict[str, Callable[[int], object]]:
    """What decodes the images of an item of each kind, and nothing else."""
    frames, folders, shards = (root / name for name in ("frames", "folders", "shards"))
    files = [Shards(shards)._files(f"rgb/{number:04}") for number in range(COUNT)]

    def of_frame(number: int) -> object:
        return [decoded((frames / kind / f"{number:04}.png").read_bytes()) for kind in ("rgb", "depth")]

    def of_folder(number: int) -> object:
        folder = folders / f"rgb__{number:04}"
        arrays = [np.load(folder / f"{name}.npy") for name in ("depth", "expected_error")]
        images = [frames / "rgb" / f"{number:04}.png", folder / "unsupported.png"]
        return arrays, [decoded(path.read_bytes()) for path in images]

    def of_shard(number: int) -> object:
        return [decoded(files[number][f"{name}.png"]) for name in KEEP]

    return {"frames": of_frame, "folders": of_folder, "shards": of_shard}


def worker_memory(item: dict) -> float:
    """The memory of the process that reads an item [MB]."""
    return resident(os.getpid())


def processor_time() -> float:
    """Of this process and of those that have ended [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in used)


def loading(path: Path, items: int) -> None:
    """Measure a DataLoader."""
    from torch.utils.data import DataLoader, RandomSampler

    from ilf.torch import FrameDataset

    data = FrameDataset(path)
    used = []
    for count in (4, 4 + items):  # the difference is without starting the workers
        sampler = RandomSampler(data, True, count)
        start = processor_time()
        assert sum(len(batch["key"]) for batch in DataLoader(data, 4, num_workers=2, sampler=sampler)) == count
        used.append(processor_time() - start)
    data.transform = worker_memory
    memory = max(float(batch.max()) for batch in DataLoader(data, num_workers=2))
    cost = (used[1] - used[0]) / items * 1000
    print(f"{path.name}: {cost:.1f} ms an item through a DataLoader, workers of {memory:.0f} MB")


def main() -> None:
    """Run the measurements."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--items", type=int, default=60)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    with tempfile.TemporaryDirectory() as name:
        root = Path(name)
        write(root)
        for kind, decoding in decoders(root).items():
            arrays = FrameArrays(root / kind)
            item, alone = milliseconds(arrays.__getitem__, options.items), milliseconds(decoding, options.items)
            print(f"{kind}: {item:.1f} ms an item, decoding alone {alone:.1f} ms, ratio {item / alone:.1f}")
            try:
                loading(root / kind, options.items)
            except ImportError:
                print("PyTorch is not installed.")


if __name__ == "__main__":
    main()
