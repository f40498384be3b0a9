"""Split of the real frames: frames for tuning, and frames for evaluation.

    ilf bench $(python -m tests.bench.frame_split choosing ../shared/data/rgbd) --seed 1
    ilf bench $(python -m tests.bench.frame_split judging ../shared/data/rgbd)

Frames for evaluation (`judging`) are run once, after tuning. Frames of NYU whose depth was filled by an algorithm
(`nyufilled_*`) are in neither list.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

SPLIT = {
    "choosing": (
        *("nyu_0433", "nyu_0464", "nyu_1407_crop", "nyu_sync_00000", "nyu_sync_00050", "nyu_sync_00100"),
        *("sevenscenes_000000", "sevenscenes_000160", "sevenscenes_000320", "slambook_joinmap_1"),
        *("osd_learn6", "osd_test42", "osd_test63", "uoc_0", "uoc_4", "uoc_8", "arc_jaw_0", "arc_jaw_1", "arc_suction"),
        *("redwood_00000", "ycbvideo_1", "cleargrasp_000000080", "cleargrasp_syn_000000000"),
    ),
    "judging": (
        *("tum_open3d", "sunrgbd_kv2", "lingbot_1", "lingbot_3", "lingbot_5", "lingbot_7"),
        *("posecnnpt_0", "posecnnpt_2", "posecnnpt_4", "ycbvideo_3", "ycbvideo_5", "redwood_00004"),
        *("slambook_joinmap_2", "slambook_joinmap_3", "slambook_joinmap_4", "slambook_joinmap_5"),
        *("sevenscenes_000080", "sevenscenes_000240", "sevenscenes_000400"),
        *("cleargrasp_000000130", "cleargrasp_syn_000000004"),
    ),
}
"""Purpose -> names of frame folders."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the folders of one half, one a line."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.frame_split", description=__doc__.partition("\n")[0])
    parser.add_argument("half", choices=SPLIT)
    parser.add_argument("folder", type=Path, help="folder that contains the frame folders")
    given = parser.parse_args(arguments)
    print("\n".join(str(given.folder / name) for name in SPLIT[given.half]))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
