"""The second twelve corrections, by one stroke each, and by any tool.

Each was written down before it was tried; what was in vain stays in the list, before `Wasted`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .hand import Action, Click, Command, Key, Stroke, Use, Wasted, stroke

STROKES: Mapping[str, Sequence[Action]] = {
    "purple pillow": [
        Use("outline"),
        Stroke(
            (
                (172, 225.5),
                (180, 223.5),
                (190, 226.5),
                (203, 231),
                (217, 231.5),
                (221, 236),
                (221.5, 241),
                (219, 252),
                (217, 260),
                (217.5, 268),
                (200, 268),
                (180, 266),
                (158.5, 262.5),
                (163, 257),
                (170, 249.5),
                (178, 242),
                (171, 236),
                (172, 225.5),
            ),
            ctrl=True,
        ),
    ],
    "post of the chair": [Use("border"), stroke((213.5, 205), (213, 235), (212.3, 262), (211, 284))],
    "shade of the lamp": [
        Use("outline"),
        Stroke(
            ((369.5, 20), (406, 20), (418, 20.5), (421, 56), (404, 55.5), (390, 57.5), (365, 54.5), (369.5, 20)),
            ctrl=True,
        ),
    ],
    "forearm": [
        Use("give"),
        stroke(
            (346, 270),
            (349.5, 276),
            (351, 283),
            (350.5, 290),
            (344, 294.5),
            (332, 296),
            (323, 298),
            (320, 304),
            (317.5, 310),
            (305, 310),
            (294, 306.5),
            (290, 300),
        ),
    ],
    "chair behind the book": [
        Use("split"),
        stroke((424, 367), (430, 366.5), (446, 368), (452, 373.5), (456, 376)),
    ],
    "plush toy": [
        Use("give"),
        stroke((214, 157), (218, 150), (224, 146), (226, 141.5), (230, 140.5), (233.5, 142.5), (237, 150)),
    ],
    "front of the sofa": [
        Use("give"),
        stroke((322, 204), (316, 206.5), (306, 208.5), (300, 211), (286, 212.5)),
    ],
    "blue pillow": [
        Use("outline"),
        Stroke(
            (
                (488, 195),
                (499, 189),
                (515, 185),
                (530, 182.5),
                (541, 176),
                (547, 179.5),
                (551, 187),
                (560, 210),
                (568, 229),
                (576, 241),
                (586, 252.5),
                (575, 256.5),
                (556, 258),
                (540, 263),
                (519, 267.5),
                (516, 263),
                (513.5, 253),
                (511, 240),
                (506, 225),
                (500, 212),
                (492, 203),
                (488, 195),
            ),
            ctrl=True,
        ),
    ],
    "forehead": [
        Use("give"),
        stroke((497, 56), (489, 54), (488, 49), (491, 43), (488, 36), (488, 26), (491.5, 18), (496, 4)),
    ],
    "desk lamp": [
        Use("outline"),
        Stroke(
            (
                (511.5, 203),
                (513.5, 197),
                (521, 195),
                (527, 198),
                (533, 192.5),
                (540, 188),
                (545, 187),
                (549.5, 190),
                (551.5, 195.5),
                (550, 200.5),
                (541, 203),
                (535, 207),
                (534.5, 216),
                (531, 221.5),
                (525, 223.5),
                (519, 221.5),
                (514, 214),
                (511.5, 203),
            ),
            ctrl=True,
        ),
    ],
    "books in the box": [
        Use("give"),
        stroke((290, 309), (291.5, 302), (296, 297), (301, 291.5), (305, 293.5), (320, 294.5), (339, 297), (348, 302)),
    ],
    "top of the chair": [
        Use("give"),
        stroke(
            (190, 258),
            (190.5, 242),
            (193, 240),
            (198, 240),
            (203, 237),
            (207.5, 237.5),
            (211, 244),
            (214.5, 250.5),
            (221, 260),
        ),
        Command("undo"),
        Wasted(2),  # begun in the block beside the chair, which got the part
        Use("border"),
        stroke(
            (191, 252), (190.5, 242), (193, 240), (203, 237), (207.5, 237.5), (211, 244), (214.5, 250.5), (220, 258)
        ),
    ],
}
"""Actions by name of the correction: one stroke each, with the tools of the first twelve."""

ALL: Mapping[str, Sequence[Action]] = {
    "purple pillow": [
        Use("smart_select"),
        Click(200, 250),
        Key("Escape"),
        Wasted(2),  # it selects the sofa
        stroke((156, 221), (224, 271)),
        Key("Return"),
    ],
    "post of the chair": [
        Use("refine"),
        stroke((216, 206), (215, 235), (214, 262), (213, 283)),
        Command("undo"),
        Wasted(3),  # the depth jumps where the border was, not where the colour does
        *STROKES["post of the chair"],
    ],
    "shade of the lamp": [Use("smart_select"), stroke((363, 18), (423, 58)), Key("Return")],
    "forearm": STROKES["forearm"],
    "chair behind the book": STROKES["chair behind the book"],
    "plush toy": STROKES["plush toy"],
    "front of the sofa": STROKES["front of the sofa"],
    "blue pillow": [
        Use("smart_select"),
        Click(535, 225),
        Key("Escape"),
        Wasted(2),  # it selects the pillows behind, too
        stroke((486, 174), (588, 270)),
        Key("Return"),
    ],
    "forehead": STROKES["forehead"],
    "desk lamp": [Use("smart_select"), stroke((509, 185), (554, 226)), Key("Return")],
    "books in the box": STROKES["books in the box"],
    "top of the chair": STROKES["top of the chair"],
}
"""The same by any tool: Smart select for objects, Refine edge for misplaced borders."""
