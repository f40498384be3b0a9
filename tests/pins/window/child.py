"""A window that is worked in until its work is autosaved, and that waits to be killed."""

import sys
import time
from pathlib import Path

from .frames import room
from .hand import Hand, isolated

_AUTOSAVE_MS = 3000


def main() -> None:
    """Work as the second argument says, in the folder that the first one names."""
    folder, what = Path(sys.argv[1]), sys.argv[2]
    with isolated(folder):
        user = Hand(folder, autosaves=True)
        user.open(room(folder))
        user.select((40, 30))
        if what == "run":
            user.set_filter("paper", 20)
            user.save()
            user.do("run_all")
        user.tool("paint")
        user.drag([(60, 40), (80, 60)])
        user.drag([(90, 40), (110, 60)])
        user.do("undo")
        user.settle(_AUTOSAVE_MS)
        print("autosaved", flush=True)
        time.sleep(600)


if __name__ == "__main__":
    main()
