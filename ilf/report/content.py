"""What a report says, before anybody has laid it out: texts, facts, tables, pictures and curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self, TypeAlias

from ..data.results import Completion
from ..drawing.blocks import block_colour
from ..drawing.colours import Colour
from ..project.frame_state import FrameState
from ..project.run_history import KeptRun
from ..project.stored import stored_completion
from ..run.run import Run


@dataclass(frozen=True)
class Paragraph:
    """A sentence or several; `warns` if something is not as it should be, `code` if it is to be typed as it stands."""

    text: str
    warns: bool = False
    code: bool = False


@dataclass(frozen=True)
class Fact:
    """What something is; hashes are set small, and broken where the line ends."""

    name: str
    text: str
    is_hash: bool = False


@dataclass(frozen=True)
class Facts:
    """Names and what they are."""

    rows: tuple[Fact, ...]


@dataclass(frozen=True)
class Column:
    """A column of a table: its heading, what that means, and whether it holds numbers, which are set right."""

    text: str
    about: str = ""
    number: bool = True


@dataclass(frozen=True)
class Cell:
    """A cell of a table.

    Attributes
    ----------
    text : str
    colour : Colour or None
        Of a small plate before the text.
    target : str
        Id of the chapter that the text leads to.
    image : Image or None
        Shown in place of the text, which then says what it is.
    about : str
        More of it, for who asks.
    """

    text: str
    colour: Colour | None = None
    target: str = ""
    image: Image | None = None
    about: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of cells under columns."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]


@dataclass(frozen=True)
class Image:
    """An encoded picture: its bytes, what they are ("png", "jpeg"), and its size in pixels."""

    data: bytes = field(repr=False)
    format: str
    width: int
    height: int


@dataclass(frozen=True)
class Legend:
    """A colour and what it stands for; of lines also how they are dashed, as SVG has it."""

    colour: Colour
    text: str
    dashes: str = ""
    is_line: bool = False


@dataclass(frozen=True)
class ColourBar:
    """Colours from one end to the other as an image of one row, and the numbers below them with their unit: at its
    beginning, in the middle and at its end."""

    image: Image
    ticks: tuple[str, str, str]


@dataclass(frozen=True)
class ScaleBar:
    """A length: the share of the picture's width that it takes, 0-1, and what it is."""

    share: float
    text: str


@dataclass(frozen=True)
class Mark:
    """A short text on a picture; its middle in shares of the picture's width and height, 0-1."""

    x: float
    y: float
    text: str


@dataclass(frozen=True)
class Picture:
    """A picture with all that it takes to read it."""

    title: str
    image: Image
    caption: str = ""
    bar: ColourBar | None = None
    scale: ScaleBar | None = None
    marks: tuple[Mark, ...] = ()
    legend: tuple[Legend, ...] = ()


@dataclass(frozen=True)
class Plot:
    """Curves: an SVG that needs no style sheet, and its legend."""

    title: str
    svg: str = field(repr=False)
    size: tuple[int, int]
    legend: tuple[Legend, ...] = ()


@dataclass(frozen=True)
class Gallery:
    """Pictures or plots, side by side where there is room."""

    items: tuple[Picture | Plot, ...]


Part: TypeAlias = Paragraph | Facts | Table | Gallery


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it."""

    title: str
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class Chapter:
    """A frame, or what there is to say about all of them. `id` is unique in its report."""

    id: str
    title: str
    lead: str
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class Report:
    """Chapters, one for each frame; the first is an index if there are several."""

    title: str
    chapters: tuple[Chapter, ...]


# What a report is about: a frame with its run, what came of it, and what is known of its blocks.


@dataclass(frozen=True, eq=False)
class Subject:
    """A frame to report on. Only the run and its completion are needed; what else there is, is told.

    Parameters
    ----------
    run : Run
        All blocks of the frame, and their parameters as they are set.
    completion : Completion
        What came of it; of no block, if nothing has been run yet.
    names, colours : mapping of int
        Block label -> what it is called, and its colour; others have their number and the colour of that.
    note : str
        The user's, of the frame.
    kept : tuple of KeptRun
        The runs that were kept of the frame.
    again : str
        The command by which it can be had again; worked out from the run if it is empty.
    problems : tuple of str
        What of it could not be read, a sentence each.
    """

    run: Run
    completion: Completion
    names: Mapping[int, str] = field(default_factory=dict)
    colours: Mapping[int, Colour] = field(default_factory=dict)
    note: str = ""
    kept: tuple[KeptRun, ...] = ()
    again: str = ""
    problems: tuple[str, ...] = ()

    @classmethod
    def of_state(cls, state: FrameState, again: str = "", problems: tuple[str, ...] = ()) -> Self:
        """A frame as a project holds it, with its present results."""
        infos = state.notes.infos
        return cls(
            replace(state.run(), dense=state.guess is not None),
            stored_completion(state),
            {label: info.name for label, info in infos.items()},
            {label: info.colour for label, info in infos.items()},
            state.note,
            state.runs,
            again,
            problems,
        )

    def name_of(self, label: int) -> str:
        """What a block is called."""
        return self.names.get(label) or f"Block {label}"

    def colour_of(self, label: int) -> Colour:
        """The colour of a block."""
        return self.colours.get(label) or block_colour(label)


@dataclass(frozen=True)
class Unreadable:
    """A frame of a project that cannot be reported on, and why."""

    name: str
    why: str
