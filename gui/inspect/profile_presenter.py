"""Brings depth along the profile line to its panel, and writes it."""

from __future__ import annotations

from PySide6.QtCore import QObject, Signal

from gui.desk import Desk
from gui.dialogs.saving import ask_path, save
from gui.inspect.profile_data import profile_data
from gui.inspect.profile_panel import ProfilePanel
from gui.state.chains import Point
from gui.state.inspection import Inspection
from gui.tools.grips import REACH, off_line, share_along
from ilf.io.atomic import write_bytes


class ProfilePresenter(QObject):
    """Depth along the present frame's profile line, as the views show it: now, or in the past.

    Signals
    -------
    place_changed()
        `place` is another one.
    """

    place_changed = Signal()

    def __init__(self, desk: Desk, inspection: Inspection, panel: ProfilePanel) -> None:
        super().__init__(panel)
        self._desk = desk
        self._inspection = inspection
        self._panel = panel
        self._pixel: tuple[int, int] | None = None
        self.place: Point | None = None
        """What the mouse is at, in the plot or on the line in a view; image coordinates."""
        panel.pointed.connect(self._point)
        desk.views.cursorMoved.connect(self._hover)

    @property
    def is_seen(self) -> bool:
        """Whether the plot can be seen."""
        return self._panel.isVisible()

    def show(self) -> None:
        """Plot what there is along the line; nothing is drawn while nobody can see it."""
        if not self.is_seen:
            return
        line, workspace = self._inspection.line, self._desk.workspace
        if line is None:
            self._panel.show_data(None)
        else:
            session = workspace.session
            data = profile_data(session, line, workspace.past)
            names = {label: session.info(label).name for label in set(data.labels.tolist()) if label}
            self._panel.show_data(data, names)
        if self._pixel is None:
            self._point(self._panel.sample)
        else:
            self.follow()

    def save_table(self) -> None:
        """Write the samples to a CSV file that the user chooses."""
        path = self._ask("Save profile as table", ".csv", "Table (*.csv)")
        data = self._panel.data
        if path and data is not None:
            save(self._desk.notes, path, lambda: write_bytes(path, data.profile.to_csv().encode()))

    def save_picture(self) -> None:
        """Write the plot to a picture that the user chooses."""
        path = self._ask("Save profile as picture", ".png", "PNG picture (*.png);;SVG picture (*.svg)")
        if path:
            as_svg = path.lower().endswith(".svg")
            content = self._panel.plot.picture(self._panel.legend_names(), as_svg)
            save(self._desk.notes, path, lambda: write_bytes(path, content))

    def _ask(self, title: str, suffix: str, kinds: str) -> str:
        if self._panel.data is None:
            self._desk.notes.tell("There is no profile to write. Draw a profile line first.")
            return ""
        name = f"{self._desk.workspace.session.name}-profile{suffix}"
        return ask_path(self._desk.window, title, name, kinds)

    def _point(self, sample: int | None) -> None:
        data = self._panel.data
        if data is None or sample is None:
            self._set_place(None)
        else:
            self._set_place((int(data.profile.columns[sample]) + 0.5, int(data.profile.rows[sample]) + 0.5))

    def _hover(self, pixel: tuple[int, int] | None) -> None:
        self._pixel = pixel

    def follow(self) -> None:
        """Mark in the plot where the mouse is on the line in a view."""
        line, data = self._inspection.line, self._panel.data
        if line is None or data is None or not self.is_seen:
            return
        sample = None
        if self._pixel is not None:
            at = self._pixel[0] + 0.5, self._pixel[1] + 0.5
            if off_line(at, *line) <= REACH * self._desk.views.pixel_size:
                sample = min(max(round(share_along(at, *line) * (len(data.profile) - 1)), 0), len(data.profile) - 1)
        self._panel.point_at(sample)
        self._point(sample)

    def _set_place(self, place: Point | None) -> None:
        if place != self.place:
            self.place = place
            self.place_changed.emit()
