"""Random events for all tools, with undo and redo: what must hold whatever a hand does."""

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from gui.tools.kinds import KINDS
from ilf.segmentation.editing.patches import border_pixels

from ..tool_host import Hand, ToolHost

LOCKED = 2
FRAME_SHAPE = (48, 64)

_point = st.tuples(st.floats(-4, 68), st.floats(-4, 52))
_keys = st.sampled_from(["", "", "", "s", "c", "a"])
_gesture = st.fixed_dictionaries(
    {
        "tool": st.sampled_from([kind.name for kind in KINDS]),
        "how": st.sampled_from(["drag", "drag", "adjusted", "clicks", "clicks", "double click", "given up", "left"]),
        "points": st.lists(_point, min_size=2, max_size=5),
        "keys": _keys,
        "chosen": st.integers(0, 4),
        "leash": st.sampled_from([0, 6]),
        "switches": st.tuples(st.booleans(), st.booleans()),
        "hand_depth": st.sampled_from([0.0, 1.5, 2.5]),
        "history": st.sampled_from(["", "", "", "undo", "redo"]),
    }
)


def _make_gesture(host, tool, gesture):
    host.options.leash = gesture["leash"]
    host.options.hand_depth = gesture["hand_depth"]
    host.options.similar_only, host.options.to_no_block = gesture["switches"]
    host.document.select([gesture["chosen"]] if gesture["chosen"] in host.document.counts() else [])
    hand, points, keys, how = Hand(tool, host), gesture["points"], gesture["keys"], gesture["how"]
    hand.hover(points[0], keys)
    if how in ("drag", "adjusted", "given up", "left"):
        hand.drag(points, keys, release=how in ("drag", "adjusted"))
        if how == "adjusted":
            hand.drag([points[0], points[-1]])
            hand.click(points[-1], "a")
    else:
        for point in points:
            hand.click(point, keys)
        if how == "double click":
            hand.double_click(points[-1])
        else:
            hand.finish()
    if how == "given up":
        tool.undo_last(host)
        tool.cancel(host)
    elif how == "left":
        host.workspace.about_to_change.emit()


def test_whatever_a_hand_does(small_frame, qapp):
    """Blocks part the frame, locked ones stay, undo and redo are exact, drawn borders are borders,
    distrusted depth is what counts as missing; depth by hand is never in locked blocks, and no proposal stays."""
    edits = 0

    @settings(
        max_examples=40,
        deadline=None,
        derandomize=True,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(gestures=st.lists(_gesture, min_size=14, max_size=24), holes=st.booleans())
    def run(gestures, holes):
        nonlocal edits
        edits += _work(small_frame, gestures, holes)

    run()
    assert edits >= 130


def _work(frame, gestures, holes):
    """Make all gestures, and check after each; then undo all, and redo all. How many edits came of them."""
    labels = np.ones(FRAME_SHAPE, np.int32)
    labels[:, 30:] = 3
    labels[30:42, 10:40] = LOCKED
    labels[:6] = 0 if holes else 4
    host = ToolHost(frame, labels)
    host.document.change_info(LOCKED, locked=True)
    tools = {kind.name: kind.make() for kind in KINDS}
    for tool in tools.values():
        host.workspace.about_to_change.connect(lambda tool=tool: tool.cancel(host))
    stack = host.document.undo_stack
    seen = {0: _state(host)}
    edits = 0
    for gesture in gestures:
        before = stack.index()
        _make_gesture(host, tools[gesture["tool"]], gesture)
        _check(host, labels)
        for tool in tools.values():
            tool.cancel(host)
        assert host.document.proposal is None
        if stack.index() > before or gesture["how"] == "adjusted":  # what was undone before is gone
            seen = {index: state for index, state in seen.items() if index <= before}
        elif gesture["how"] in ("given up", "left"):
            _compare(host, seen[before])
        seen[stack.index()] = _state(host)
        edits += stack.index() - before
        if gesture["history"]:
            getattr(stack, gesture["history"])()
        _compare(host, seen.setdefault(stack.index(), _state(host)))
    while stack.canUndo():
        stack.undo()
        _check(host, labels)
        if stack.index() in seen:
            _compare(host, seen[stack.index()])
    assert np.array_equal(host.labels, labels)
    assert host.document.frame.invalid_mask is None
    assert not _drawn(host).any()
    assert host.document.blocks.by_hand is None
    while stack.canRedo():
        stack.redo()
        if stack.index() in seen:
            _compare(host, seen[stack.index()])
    return edits


def _state(host):
    return host.labels.copy(), host.document.frame.known.copy(), _drawn(host), _by_hand(host)


def _by_hand(host):
    """Depth by hand, 0 for none."""
    by_hand = host.document.blocks.by_hand
    return np.zeros(FRAME_SHAPE) if by_hand is None else np.nan_to_num(by_hand.depth)


def _drawn(host):
    drawn = host.document.blocks.drawn
    return np.zeros(FRAME_SHAPE, bool) if drawn is None else drawn.copy()


def _compare(host, state):
    for now, then in zip(_state(host), state, strict=True):
        assert np.array_equal(now, then)


def _check(host, labels):
    frame = host.document.frame
    assert host.labels.dtype == np.int32
    assert host.labels.min() >= 0
    assert sum(counts.pixels for counts in host.document.counts().values()) == np.count_nonzero(host.labels)
    assert np.array_equal(host.labels == LOCKED, labels == LOCKED)
    measured = np.isfinite(frame.measured)
    invalid_mask = np.zeros(frame.shape, bool) if frame.invalid_mask is None else frame.invalid_mask
    assert not (invalid_mask & ~measured).any()
    assert np.array_equal(frame.known, measured & ~invalid_mask)
    assert not (_drawn(host) & ~border_pixels(host.labels)).any()
    by_hand = _by_hand(host)
    settable = np.append(frame.measured[measured], [0.0, 1.5, 2.5])  # by Ctrl, and by the tool's option
    assert np.isin(by_hand, settable).all()
    assert not by_hand[host.labels == LOCKED].any()
