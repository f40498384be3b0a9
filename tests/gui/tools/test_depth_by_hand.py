"""The tool Depth by hand without a window: what it paints, proposes and refuses."""

import numpy as np
import pytest

from gui.state.parts import Part
from gui.tools.depth_by_hand import DepthByHandTool
from gui.views.interaction import PointerKind
from ilf.data.frame import RGBDFrame
from ilf.errors import InputError

from ..tool_host import Hand, ToolHost

LEFT_HOLE, RIGHT_HOLE = np.s_[10:22, 8:20], np.s_[30:40, 40:56]


@pytest.fixture
def hand(small_frame, small_labels, qapp):
    return Hand(DepthByHandTool(), ToolHost(small_frame, small_labels))


def _depth(hand: Hand) -> np.ndarray:
    by_hand = hand.host.document.blocks.by_hand
    return np.full((48, 64), np.nan, np.float32) if by_hand is None else by_hand.depth


def test_strokes_stay_in_the_selected_blocks_and_out_of_locked_ones(hand):
    host = hand.host
    host.options.hand_depth = 2.0
    host.document.select([2])
    hand.drag([(10, 16), (18, 16)])
    assert "The selected blocks have no missing depth here" in host.said[-1]
    host.document.select([])
    host.document.change_info(1, locked=True)
    hand.drag([(10, 16), (18, 16)])
    assert "is locked" in host.said[-1]
    hand.drag([(40, 5), (45, 5)])
    assert "Nothing is missing here" in host.said[-1]
    host.attempt(lambda: hand.tool.fill(host))
    assert host.said[-1] == "Select the block with the hole first."
    assert host.steps == []
    host.document.select([2])
    hand.tool.fill(host)
    assert np.array_equal(np.isfinite(_depth(hand)), host.document.frame.missing & (host.labels == 2))
    hand.tool.erase(host)
    assert host.document.blocks.by_hand is None


def test_depth_beyond_sensors_is_refused(hand):
    with pytest.raises(InputError, match="0 to 300 m"):
        hand.host.workspace.current.set_by_hand(
            np.full((48, 64), 301, np.float32), hand.host.document.frame.missing, "Paint depth"
        )
    assert hand.host.steps == []


def test_a_plane_is_proposed_limited_and_taken(hand):
    host, rows = hand.host, np.mgrid[:48, :64][0]
    host.document.select([1])
    hand.tool.propose_plane(host)
    proposal = host.document.proposal
    np.testing.assert_allclose(proposal[LEFT_HOLE], (1.5 + 0.004 * rows)[LEFT_HOLE], rtol=2e-3)
    assert np.isnan(proposal[RIGHT_HOLE]).all()
    assert host.steps == []
    assert "Enter: take" in hand.tool.hint
    hand.drag([(9, 12), (18, 12)])
    limited = host.document.proposal
    assert np.isfinite(limited[11:13, 9:18]).all()
    assert np.isnan(limited[20]).all()
    assert hand.finish()
    assert host.document.proposal is None
    assert np.array_equal(_depth(hand), limited, equal_nan=True)
    assert host.steps == ["Continue plane"]


def test_the_rectangle_says_which_plane(hand):
    host = hand.host
    host.document.select([1])
    host.workspace.current.look(Part.REGION, region=(slice(2, 9), slice(34, 60)))
    hand.tool.propose_plane(host)
    assert np.nanmedian(host.document.proposal) == pytest.approx(2.4 + 0.005 * 14, rel=0.02), "that of the other wall"
    host.workspace.current.look(Part.REGION, region=(slice(12, 15), slice(10, 15)))
    hand.tool.propose_plane(host)
    assert "at least 12 pixels" in host.said[-1]
    assert host.document.proposal is None


def test_a_hole_between_two_surfaces_goes_to_either(small_frame, qapp):
    depth = small_frame.measured.copy()
    depth[12:36, 20:40] = np.nan
    host = ToolHost(RGBDFrame(small_frame.rgb, depth), np.ones((48, 64), np.int32))
    tool = DepthByHandTool()
    host.document.select([1])
    for nearer in (True, False):
        tool.propose_surface(host, nearer)
        found = float(np.nanmedian(host.document.proposal[20:30, 25:35]))
        assert found == pytest.approx(1.6 if nearer else 2.55, rel=0.05)
    Hand(tool, host).send(PointerKind.HOVER, (30, 20))
    assert tool.finish(host)
    assert host.steps == ["Farther surface"]
