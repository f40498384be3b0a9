"""What the architecture page says of adding a sink is true: one class."""

import pickle
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import ilf
from ilf.batch.engine import Sink, complete_many
from ilf.batch.frames import frames_of_sources
from ilf.batch.settings import BatchSettings
from tests.ilf.small_frames import write_small_frame


@dataclass(frozen=True, eq=False, kw_only=True)
class Depths(Sink):
    """An array of completed depth for each frame, and its outcome beside it, which is written last."""

    folder: Path

    def done(self, frame):
        path = self.folder / f"{frame.folder}.outcome"
        return pickle.loads(path.read_bytes()) if path.exists() else None

    def write(self, frame, reading, completion):
        np.save(self.folder / f"{frame.folder}.npy", completion.depth)
        return True, ()

    def put(self, frame, outcome, written=None):
        (self.folder / f"{frame.folder}.outcome").write_bytes(pickle.dumps(outcome))

    def bare(self):
        return replace(self, to_do=())

    def check_here(self):
        """Any machine gives the same."""

    def outcomes(self, unit):
        yield from filter(None, [self.done(unit)])

    def close(self):
        """Each frame is stored by itself."""


def test_a_new_sink_is_one_class(tmp_path):
    for name in ("a", "b"):
        write_small_frame(tmp_path / "in" / name)
    frames = tuple(frames_of_sources([ilf.open_source(tmp_path / "in")]))
    (tmp_path / "out").mkdir()
    settings = BatchSettings(parameters=ilf.preset(max_iterations=3))
    sink = Depths(settings=settings, folder=tmp_path / "out", to_do=frames)
    assert [outcome.is_completed for outcome in complete_many(sink)] == [True, True]
    for frame in frames:
        assert np.isfinite(np.load(tmp_path / "out" / f"{frame.folder}.npy")).mean() > 0.9
    assert all(sink.done(frame) for frame in frames), "what is in the sink is not done again"
