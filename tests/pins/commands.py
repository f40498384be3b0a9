"""Commands whose files are pinned, run one after the other in a folder with the frames."""

import os
import subprocess
import sys
from contextlib import chdir, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

import ilf
import ilf.cli

from .frames import CAMERA, hills, room, sparse, write_frame, write_sequence
from .hashes import Hashes, of_files
from .settings import left_borders, other_guide, stated, with_mask

COMMANDS = {
    "complete": "complete hills --mesh glb --out {out}",
    "sparse": "complete sparse --extrapolate --png-units 10000 --out {out}",
    "inputs": "complete hills --invalid-mask invalid.png --drawn borders.png --by-hand by-hand.npy "
    "--by-hand-weight 0.7 --guide guide.npy --out {out}",
    "neighbours": "complete wall --frame frame-000001.color --intrinsics {camera} --neighbours 1 --axes world "
    "--out {out}",
    "replay": "complete --replay out/inputs/run.json --out {out}",
    "replay-neighbours": "complete --replay out/neighbours/run.json --out {out}",
    "blocks": "blocks hills --out {out}/blocks.json --stages {out}/stages",
    "labelme": "blocks hills --from out/blocks/blocks.json --keep 1,3 --format labelme --out {out}/blocks.json",
    "fill-gaps": "complete hills --blocks out/labelme/blocks.json --fill-gaps --out {out}",
    "batch": "batch wall --intrinsics {camera} --max-iterations 40 --json --out {out}",
    "nerfstudio": "project export out/batch --to nerfstudio --out {out}",
    "project": "project new hills.ilf hills",
    "export": "project export hills.ilf --complete --out {out}",
    "evaluate": "evaluate room --preset best --preset paper --json",
    "hold-out": "evaluate hills --hold-out random --seeds 1 --json",
    "info": "info hills --json",
    "stream": "stream wall --intrinsics {camera} --out {out}",
    "without-numba": "complete hills --out {out}",
}
"""Name -> arguments of `ilf`; what a command prints as JSON is one more file."""


def make() -> dict[str, Hashes]:
    """Hashes of the files that the commands write."""
    with TemporaryDirectory() as temporary, chdir(temporary):
        _write_inputs()
        table = {}
        for name, line in COMMANDS.items():
            out = Path("out", name)
            out.mkdir(parents=True)
            words = line.format(out=out, camera=",".join(map(str, CAMERA))).split()
            printed = _run_without_numba(words) if name == "without-numba" else _run(words)
            if "--json" in words:
                (out / "printed.json").write_text(printed)
            table[f"ilf {name}"] = of_files(out)
        return table


def _write_inputs() -> None:
    """Write the frames into folders of their own, and inputs for "hills"."""
    for frame in (room(), sparse(), hills()):
        write_frame(Path(frame.name), frame)
    write_sequence(Path("wall"))
    frame = hills()
    blocks = ilf.extract_blocks(frame)
    cv2.imwrite("invalid.png", with_mask(frame).invalid_mask * np.uint8(255))
    cv2.imwrite("borders.png", left_borders(frame, blocks) * np.uint8(255))
    np.save("by-hand.npy", stated(frame, blocks))
    np.save("guide.npy", other_guide(frame, blocks))


def _run(words: list[str]) -> str:
    """What `ilf` prints, run in this process."""
    with redirect_stdout(StringIO()) as printed, redirect_stderr(StringIO()) as told:
        status = ilf.cli.main(words)
    if status:
        raise RuntimeError(f"`ilf {' '.join(words)}` ended with status {status}: {told.getvalue()}")
    return printed.getvalue()


def _run_without_numba(words: list[str]) -> str:
    """The same in a process whose loops are not compiled."""
    package = {"PYTHONPATH": str(Path(ilf.__file__).parents[1]), "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, "-m", "ilf", *words]
    return subprocess.run(command, env=os.environ | package, check=True, capture_output=True, text=True).stdout
