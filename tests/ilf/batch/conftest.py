import pytest

from ..batch_frames import work_in_this_process, write_frames


@pytest.fixture
def source(tmp_path):
    """A folder of five small frames."""
    return write_frames(tmp_path / "in", 5)


@pytest.fixture
def begun(monkeypatch):
    """There are no other processes; the keys of the frames whose completion was begun."""
    return work_in_this_process(monkeypatch)
