"""The content of a report, independent of its layout: texts, facts, tables, pictures and curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Self, TypeAlias

from ..data.results import Completion
from ..drawing.blocks import block_colour
from ..drawing.colours import Colour
from ..project.facts import present_completion
from ..project.frame_state import FrameState
from ..project.run_history import StoredRun
from ..run.run import Run


@dataclass(frozen=True)
class Paragraph:
    """One or more sentences; `warns` marks a warning, `code` a command to type."""

    text: str
    warns: bool = False
    code: bool = False


@dataclass(frozen=True)
class Fact:
    """A name with its value; hashes are set small and wrapped."""

    name: str
    text: str
    is_hash: bool = False


@dataclass(frozen=True)
class Facts:
    """A list of names with their values."""

    rows: tuple[Fact, ...]


@dataclass(frozen=True)
class Column:
    """A column of a table: its heading, a tooltip, and whether it contains numbers, which are right-aligned."""

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
        Colour of a small swatch before the text.
    target : str
        Id of the chapter that the text links to.
    image : Image or None
        Shown instead of the text, which is then its alternative text.
    about : str
        Tooltip.
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
    """An encoded picture: its bytes, format ("png", "jpeg") and size in pixels."""

    data: bytes = field(repr=False)
    format: str
    width: int
    height: int


@dataclass(frozen=True)
class Legend:
    """A legend entry: a colour and its meaning; for lines also the dash pattern, as in SVG."""

    colour: Colour
    text: str
    dashes: str = ""
    is_line: bool = False


@dataclass(frozen=True)
class ColourBar:
    """A colour bar: an image of one row, and the labels with units at its start, middle and end."""

    image: Image
    ticks: tuple[str, str, str]


@dataclass(frozen=True)
class ScaleBar:
    """A scale bar: its share of the picture's width, 0-1, and its label."""

    share: float
    text: str


@dataclass(frozen=True)
class Mark:
    """A short text on a picture; its centre as shares of the picture's width and height, 0-1."""

    x: float
    y: float
    text: str


@dataclass(frozen=True)
class Picture:
    """A picture with its caption, colour bar, scale bar, marks and legend."""

    title: str
    image: Image
    caption: str = ""
    bar: ColourBar | None = None
    scale: ScaleBar | None = None
    marks: tuple[Mark, ...] = ()
    legend: tuple[Legend, ...] = ()


@dataclass(frozen=True)
class Plot:
    """A plot of curves: an SVG that needs no style sheet, and its legend."""

    title: str
    svg: str = field(repr=False)
    size: tuple[int, int]
    legend: tuple[Legend, ...] = ()


@dataclass(frozen=True)
class Gallery:
    """Pictures or plots, side by side if there is space."""

    items: tuple[Picture | Plot, ...]


Element: TypeAlias = Paragraph | Facts | Table | Gallery


@dataclass(frozen=True)
class Section:
    """A heading and its content."""

    title: str
    parts: tuple[Element, ...]


@dataclass(frozen=True)
class Chapter:
    """The chapter of a frame, or the index of all frames. `id` is unique in the report."""

    id: str
    title: str
    lead: str
    sections: tuple[Section, ...]


@dataclass(frozen=True)
class Report:
    """A report: one chapter per frame, after an index if there are several."""

    title: str
    chapters: tuple[Chapter, ...]


# The subject of a report: a frame with its run, completion and blocks.


@dataclass(frozen=True, eq=False)
class Subject:
    """A frame to report on. Only the run and its completion are required.

    Parameters
    ----------
    run : Run
        All blocks of the frame, and their parameters as they are set.
    completion : Completion
        Its results; without blocks if nothing has been run yet.
    names, colours : mapping of int
        Block label -> name and colour; the defaults follow from the label.
    note : str
        The user's note on the frame.
    kept : tuple of StoredRun
        Run history of the frame.
    again : str
        Command that reproduces the run; derived from the run if empty.
    problems : tuple of str
        What could not be read, one sentence each.
    """

    run: Run
    completion: Completion
    names: Mapping[int, str] = field(default_factory=dict)
    colours: Mapping[int, Colour] = field(default_factory=dict)
    note: str = ""
    kept: tuple[StoredRun, ...] = ()
    again: str = ""
    problems: tuple[str, ...] = ()

    @classmethod
    def of_state(cls, state: FrameState, again: str = "", problems: tuple[str, ...] = ()) -> Self:
        """Return the subject of a frame in a project, with its present results."""
        infos = state.notes.infos
        return cls(
            replace(state.run(), extrapolate=state.extrapolation is not None),
            present_completion(state),
            {label: info.name for label, info in infos.items()},
            {label: info.colour for label, info in infos.items()},
            state.note,
            state.runs,
            again,
            problems,
        )

    def name_of(self, label: int) -> str:
        """Return the name of a block."""
        return self.names.get(label) or f"Block {label}"

    def colour_of(self, label: int) -> Colour:
        """Return the colour of a block."""
        return self.colours.get(label) or block_colour(label)


@dataclass(frozen=True)
class Unreadable:
    """A frame that cannot be reported on, and the reason."""

    name: str
    why: str
