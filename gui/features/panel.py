"""The base of panels: shown parts of the state, and what is computed for them in a worker."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QWidget

from ..state.parts import NO_PART, Part
from ..widgets.basics import Late
from ..widgets.docks import PanelGroup
from ..widgets.work_row import WorkRow
from .context import Context, Feature


class Panel(Feature):
    """A panel of the window: a widget in a dock, drawn only while it is visible.

    A subclass declares the attributes, makes its widget in `make`, when it is first shown, and draws it in `refresh`.
    One that is made `at_start` is open at the first start.

    Attributes
    ----------
    title, icon : str
        Of its dock ("ph.target").
    group : PanelGroup or None
        The panels that share a place; None for a panel that is no dock: who makes the window places its widget.
    parts : Part
        The parts of the state that it shows: it is drawn in the turn in which one of them changes.
    deferred : Part
        Those that change several times a second by themselves, as in a run: it is drawn when there is time.
    shows : str
        Other words for what it shows, by which it is found; "" for none.
    work : WorkRow
        Progress of the computation, with *Cancel*, from the first share on that is told; a panel that computes in steps
        places it in its widget.
    """

    title: ClassVar[str]
    icon: ClassVar[str]
    group: ClassVar[PanelGroup | None]
    parts: ClassVar[Part]
    deferred: ClassVar[Part] = NO_PART
    shows: ClassVar[str] = ""

    @classmethod
    def declare(cls, context: Context) -> None:
        super().declare(context)

        def is_seen() -> bool:
            panel = context.made(cls)
            return panel is not None and (panel.visible or any(map(context.views.shows, cls.contents)))

        def draw() -> None:
            context.feature(cls).refresh(context.refresh.changed(cls.title))

        context.refresh.add(cls.title, draw, cls.parts, cls.deferred, when=is_seen)
        if cls.group is not None:
            widget = context.feature(cls).widget if cls.at_start else Late(lambda: context.feature(cls).in_dock)
            context.panels.add(cls.title, widget, cls.group, cls.icon, cls.at_start, cls.shows)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.redraw()

    @property
    def in_dock(self) -> QWidget:
        """What its dock contains."""
        return self.widget

    @cached_property
    def work(self) -> WorkRow:
        work = WorkRow(self.what)
        work.follow(self.requests)
        return work

    @cached_property
    def widget(self) -> QWidget:
        """Its content, made when it is first shown or asked for."""
        widget = self.make()
        widget.installEventFilter(self)
        return widget

    @property
    def made(self) -> bool:
        """Whether it was shown before."""
        return "widget" in vars(self)

    def make(self) -> QWidget:
        """Make the widget of the panel."""
        raise NotImplementedError

    def refresh(self, parts: Part) -> None:
        """Draw the panel; `parts` have changed since it was drawn last. Called only while it is visible."""
        raise NotImplementedError

    @property
    def visible(self) -> bool:
        """Whether the panel is open, in front of the other tabs of its place."""
        return self.made and self.widget.isVisible()

    def reveal(self) -> None:
        """Open the panel in front of the other tabs of its place."""
        _ = self.widget  # made even if the window is not shown yet
        self.context.panels.reveal(self.title)

    def redraw(self) -> None:
        """Draw the panel at the next turn, as after a change of one of its own controls."""
        self.context.refresh.mark(self.title)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Draw what has changed while the panel was not visible, and all in the colours of a new theme."""
        if watched is self.widget and event.type() == QEvent.Type.Show:
            self.context.refresh.mark(self.title, "commands")  # its buttons are seen now
        elif watched is self.widget and event.type() == QEvent.Type.PaletteChange:
            self.redraw()
        return super().eventFilter(watched, event)
