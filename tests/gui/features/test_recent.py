"""What was opened last is offered again, as it was read, in this session and the next."""

import json

import pytest
from PySide6.QtCore import QSettings

from gui.features.documents.recent import MOST, RecentMenu, name_of
from ilf.data.camera import Camera
from ilf.sources.frame_ref import FrameRef, ReadingOptions

WRONG_OPTIONS = (
    {"depth_units": "1000"},
    {"encoding": True},
    {"invalid": float("nan")},
    {"intrinsics": 5},
    {"intrinsics": [1, "1", 0, 0]},
    {"ground_truth": 1},
    {"guide": ["a"]},
)

pytestmark = pytest.mark.usefixtures("qapp")


def _recent() -> RecentMenu:
    return RecentMenu(lambda origin: None, None)


def test_the_last_comes_first_once_and_how_it_was_read_is_kept(tmp_path):
    frames = _recent()
    folder, record = FrameRef(str(tmp_path)), tmp_path / "out" / "run.json"
    colour, depth, ground_truth, guide = (str(tmp_path / name) for name in ("a.png", "b.png", "t.npy", "g.npy"))
    options = ReadingOptions(
        depth_units=5000.0,
        intrinsics=(525.0, 525.0, 319.5, 239.5),
        ground_truth=ground_truth,
        ground_truth_units=1.0,
        guide=guide,
    )
    pair = FrameRef(colour, depth, options=options)
    for origin in (folder, pair, record, folder):
        frames.note(origin)
    later = _recent()
    assert later.origins == [folder, record, pair]
    assert [name_of(origin) for origin in later.origins] == [tmp_path.name, "out/run.json", f"{tmp_path.name}/a.png"]
    assert later.there() == [folder], "the files of the others do not exist"
    for number in range(MOST + 3):
        later.note(FrameRef(str(tmp_path / str(number))))
    assert len(later.origins) == MOST


@pytest.mark.parametrize("camera", [Camera(1, 1, 0, 0, "own"), "kinect-v2", {"K": [1.0, 1.0, 0.0, 0.0]}])
def test_every_kind_of_camera_is_kept(tmp_path, camera):
    origin = FrameRef(str(tmp_path), options=ReadingOptions(intrinsics=camera))
    _recent().note(origin)
    assert _recent().origins == [origin]


@pytest.mark.parametrize(
    "damaged",
    [7, {}, {"file": 7}, *({"rgb": "a", "depth": "b", "frame": None, **wrong} for wrong in WRONG_OPTIONS)],
)
def test_a_damaged_entry_costs_no_other(tmp_path, damaged):
    folder, record = FrameRef(str(tmp_path)), tmp_path / "run.json"
    entries = [folder.to_json(), damaged, {"file": str(record)}]
    QSettings().setValue("recent/frames", json.dumps(entries))
    assert _recent().origins == [folder, record]


@pytest.mark.parametrize("kept", ["", "{", "[1]", '[{"rgb": "a"}]', '[{"file": 7}]', "7", "[" * 10**5])
def test_settings_that_are_damaged_offer_nothing(kept):
    QSettings().setValue("recent/frames", kept)
    assert _recent().origins == []


def test_an_empty_list_offers_nothing(tmp_path):
    frames = _recent()
    frames.note(FrameRef(str(tmp_path)))
    frames.aboutToShow.emit()
    frames.actions()[-1].trigger()
    frames.aboutToShow.emit()
    assert (frames.origins, frames.actions()) == ([], [])
