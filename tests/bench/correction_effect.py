"""Effect of the learned correction on hold-outs: `python -m tests.bench.correction_effect FRAME ... [--seeds 1 2]`.

Depth of every frame is held out, and the frame is completed with and without the correction. With `--second`, only the
second correction, that of sparse depth (`--pattern points`, `--pattern lines`), is left out. Prints the errors without
it, their ratios, geometric means over frames and seeds, and how often the correction is better.
"""

import argparse
from pathlib import Path
from unittest.mock import patch

import numpy as np

import ilf
from ilf.completion.correction import UNCORRECTED, CorrectionNetwork
from ilf.evaluation.bench.frames import find_frames, load_bench_frame, make_task
from ilf.evaluation.bench.runner import score


def main() -> None:
    """Print for every frame the ratio of errors with and without the correction, RMSE and MAE, and geometric means."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("frames", nargs="+", type=Path)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--pattern", default="areas")
    parser.add_argument("--network", type=Path, help="correction network to use instead of the bundled one")
    parser.add_argument("--second", action="store_true", help="effect of the second correction alone")
    arguments = parser.parse_args()
    network = arguments.network and CorrectionNetwork.load(arguments.network)
    ratios = []
    with patch.object(CorrectionNetwork, "bundled", lambda: network) if network else patch.dict({}):
        for folder in find_frames(arguments.frames):
            source = load_bench_frame(folder)
            for seed in arguments.seeds:
                task = make_task(source, arguments.pattern, seed)
                blocks = ilf.extract_blocks(task.frame)
                found = score(ilf.complete(task.frame, blocks).depth, task)
                if arguments.second:
                    # in a frame of its own, which has no correction in its cache
                    same = make_task(source, arguments.pattern, seed).frame
                    with patch("ilf.completion.correction.SPARSE", 0.0):
                        without = score(ilf.complete(same, blocks).depth, task)
                else:
                    without = score(ilf.complete(task.frame, blocks, UNCORRECTED).depth, task)
                ratios.append((found.rmse / without.rmse, found.mae / without.mae))
                print(
                    f"{folder.name:26} seed {seed}  {1000 * without.rmse:6.1f} {1000 * without.mae:6.1f} mm  "
                    f"{ratios[-1][0]:.3f} {ratios[-1][1]:.3f}",
                    flush=True,
                )
    rmse, mae = np.exp(np.mean(np.log(ratios), axis=0))
    better = np.mean(np.less(ratios, 1), axis=0)
    print(
        f"\nErrors with the correction / without, geometric mean: RMSE {rmse:.3f}, MAE {mae:.3f}; smaller in "
        f"{better[0]:.0%} and {better[1]:.0%} of {len(ratios)}; largest {np.max(ratios):.2f}"
    )


if __name__ == "__main__":
    main()
