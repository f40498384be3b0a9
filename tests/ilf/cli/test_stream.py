"""`ilf stream`: a recording, frame after frame, into one MCAP file or a folder."""

import numpy as np
import pytest

import ilf
from ilf.cli import main
from tests.ilf.bags import write_aligned
from tests.ilf.small_frames import write_small_frame


def test_a_recording_becomes_a_recording(tmp_path, cli):
    source, out = write_aligned(tmp_path, "mcap"), tmp_path / "out.mcap"
    assert cli("stream", source, "--out", out, "--preset", "best").out.startswith("3 frames, 1 scene, ")
    recording, given = ilf.open_source(out), ilf.open_source(source)
    assert recording.keys == given.keys
    for frame, before in zip(recording, given, strict=True):
        assert np.array_equal(frame.rgb, before.rgb)
        assert np.isfinite(frame.depth).all()
        assert np.array_equal(frame.depth[before.known], before.depth[before.known])
    assert "already exists" in cli("stream", source, "--out", out, status=1).err


def test_a_folder_gets_a_frame_in_each_of_its_folders(tmp_path, capsys):
    write_small_frame(tmp_path / "in" / "a")
    out = tmp_path / "out"
    assert main(["stream", str(tmp_path / "in"), "--out", str(tmp_path / "no.mcap")]) == 1
    assert "no timestamps. Give the frame rate (--rate)." in capsys.readouterr().err
    assert main(["stream", str(tmp_path / "in"), "--out", str(out)]) == 0
    (frame,) = ilf.open_source(out)
    assert np.isfinite(frame.depth).all()
    assert sorted(path.name for path in (out / "000000").iterdir()) == [
        "depth.tiff",
        "expected_error.tiff",
        "meta.json",
        "rgb.png",
    ]


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        (["stream", "in", "--out", "a.bag"], 1, ".bag is the file type of ROS 1"),
        (["stream", "in", "--out", "a", "--rate", "0"], 1, "--rate must be more than 0"),
        (["stream", "in", "--results", "--out", "a.mcap"], 1, "in contains no results"),
    ],
)
def test_what_cannot_be_done_is_told_and_nothing_is_written(tmp_path, monkeypatch, cli, words, status, said):
    monkeypatch.chdir(tmp_path)
    write_small_frame(tmp_path / "in" / "b")
    assert said in cli(*words, status=status).err
    assert [path.name for path in tmp_path.iterdir()] == ["in"]
