"""The corrections by brush and straight split, as a careful user does them in one pass.

The block that should grow is selected, and the brush moves along the true border with its rim on it, back and forth
where the piece is wider than the brush.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .hand import Action, Brush, Click, Command, Use, stroke


def _grow(x: float, y: float, radius: float) -> list[Action]:
    """Select the block at a point, and the brush size."""
    return [Use("select"), Click(x, y), Use("paint"), Brush(radius)]


ACTIONS: Mapping[str, Sequence[Action]] = {
    "lamp shade": [
        *_grow(300, 192, 5),
        stroke(
            (311, 152),
            (320, 152.5),
            (325, 160),
            (328.5, 167),
            (331, 172.8),
            (315, 173),
            (300, 171.8),
            (306, 162),
            (310, 154),
        ),
        stroke((316, 158), (320, 165), (308, 167)),
    ],
    "sofa side": [
        *_grow(380, 430, 5),
        stroke((371, 343), (369, 351), (365, 363), (362, 373), (360, 381), (364, 377), (367, 360)),
    ],
    "strip of floor": [
        *_grow(380, 430, 5),
        stroke((374, 343), (374, 394), (378, 375), (380, 344)),
    ],
    "stool leg": [
        *_grow(562, 340, 5),
        stroke((578, 252), (577, 256), (574, 269), (571, 284), (568, 299), (565, 312), (563, 325)),
        stroke((565, 308), (568, 285), (569, 268), (572, 259)),
    ],
    "foot of the door": [
        *_grow(443, 300, 5),
        stroke((448.5, 302), (447.8, 315), (447.3, 330), (447, 343), (445.5, 355), (444, 367), (442.3, 376)),
    ],
    "rim of the table": [
        *_grow(580, 340, 5),
        stroke(
            (512, 318.5),
            (523, 319),
            (549, 322.5),
            (564, 326.5),
            (564, 333),
            (557, 334.5),
            (545, 331.5),
            (520, 329),
            (512, 328),
        ),
    ],
    "gap beside the table": [Use("split"), stroke((436, 236), (487, 304))],
    "side of the oven": [
        Use("split"),
        stroke((353.5, 106), (353.5, 158)),
        Use("select"),
        Click(380, 100),
        Click(365, 135, ctrl=True),
        Command("merge_blocks"),
    ],
    "gap under the armrest": [
        Command("new_block"),
        Brush(5),
        stroke((324, 382), (345, 383.5), (348, 394), (352, 403.5), (340, 402.8), (325, 401.5), (324, 386)),
        stroke((331, 390), (341, 391), (341, 396), (331, 395)),
    ],
    "carpet under the table": [
        *_grow(280, 380, 3),
        stroke((236, 336), (236, 318.5), (240, 316.3), (261, 328), (251, 329.5), (240, 322), (241, 332), (252, 331)),
    ],
    "corner of the room": [
        *_grow(430, 60, 5),
        stroke((470.5, 60), (468.5, 90), (466.5, 120), (464, 150), (463, 164), (459, 158), (459, 120), (463, 109)),
    ],
    "lamp before the window": [
        Command("new_block"),
        Brush(5),
        stroke(
            (518, 80),
            (525, 77.2),
            (532, 78),
            (541, 85),
            (543, 92),
            (533, 100),
            (525, 103.5),
            (518.5, 104.5),
            (517.5, 84),
        ),
        stroke((524, 86), (534, 88), (525, 95)),
        Brush(2),
        stroke((518, 110), (511, 118), (514, 107)),
    ],
}
"""Actions by name of the correction."""
