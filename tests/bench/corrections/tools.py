"""The corrections by give, border, split and outline, as an experienced user does: one stroke each, no selection.

The line follows the true border. A part that belongs to a neighbouring block is cut off from that block's side; a
misplaced border is drawn again; a new block is split off, or outlined.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .hand import Action, Stroke, Use, stroke

ACTIONS: Mapping[str, Sequence[Action]] = {
    "lamp shade": [
        Use("give"),
        stroke(
            (314, 187),
            (311, 178.5),
            (300, 177),
            (294.5, 175.5),
            (292, 172.5),
            (293.5, 170),
            (299, 164),
            (302.5, 159),
            (305, 153),
            (307, 149),
            (309, 147),
            (314, 146),
            (321, 147.5),
            (325, 149.5),
            (328.5, 154),
            (331, 159),
            (334, 166),
            (337, 174),
            (338.3, 178),
            (317, 178.5),
            (314, 187),
        ),
    ],
    "sofa side": [Use("give"), stroke((358, 388), (354.5, 382), (357, 372), (360, 362), (364, 350), (367.5, 338))],
    "strip of floor": [Use("give"), stroke((371, 333), (366.5, 337), (366, 343))],
    "stool leg": [
        Use("give"),
        stroke(
            (564, 331),
            (568, 326),
            (570, 313),
            (573, 300),
            (576, 285),
            (579, 270),
            (582, 256),
            (584, 247),
            (569, 245.5),
        ),
    ],
    "foot of the door": [
        Use("border"),
        stroke((445, 299), (453.5, 303), (452.8, 315), (452.3, 330), (452, 343), (450.5, 355), (449, 367), (447, 381)),
    ],
    "rim of the table": [Use("give"), stroke((562, 340.5), (557, 339.5), (545, 336.5), (520, 334), (505, 333))],
    "gap beside the table": [
        Use("split"),
        stroke((441, 242.5), (447, 250), (455, 260), (463, 270), (471, 280.5), (479, 291.5), (484, 300)),
    ],
    "side of the oven": [Use("give"), stroke((354, 107), (353.5, 112), (353.5, 154))],
    "gap under the armrest": [
        Use("split"),
        stroke((313, 403), (318, 406), (330, 407), (345, 408), (356, 408.5), (357.5, 402)),
    ],
    "carpet under the table": [
        Use("border"),
        stroke((233, 340), (233, 316), (241, 313.5), (262, 325), (270, 329)),
    ],
    "corner of the room": [
        Use("border"),
        stroke((475, 56), (473.5, 90), (471.5, 120), (469, 150), (468, 164)),
    ],
    "lamp before the window": [
        Use("outline"),
        Stroke(
            (
                (512, 85),
                (514, 78),
                (518, 74),
                (524, 72),
                (531, 72.5),
                (539, 76.5),
                (545, 82),
                (548.5, 88),
                (548.5, 94),
                (546, 97.5),
                (541, 100.5),
                (533, 105.5),
                (526, 109),
                (521, 112.5),
                (516, 115),
                (513.5, 120),
                (510, 120.5),
                (508.5, 118),
                (509.5, 113),
                (511, 107.5),
                (512.5, 104),
                (513, 99),
                (513, 92),
                (512, 85),
            ),
            ctrl=True,
        ),
    ],
}
"""Actions by name of the correction."""
