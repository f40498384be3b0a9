"""The dialog *Guide by network*: known networks and the user's own, which are fetched, added and used as guide."""

from __future__ import annotations

from collections.abc import Callable
from urllib.parse import urlsplit

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QDialogButtonBox, QPushButton, QTreeWidgetItem, QWidget
from shiboken6 import isValid

from ilf.data.guide import Gives, GuideCard
from ilf.io.frame_additions import NETWORK_SUFFIX
from ilf.io.guide_models import add_guide, fetch_guide, guide_cards, guide_file, licence_text, state_of

from ..widgets.basics import Message, combo, give_size, label_of, row, row_list, stack
from ..widgets.file_choice import choose_file
from ..widgets.notes import Notes
from ..widgets.notices import error_text
from ..widgets.work_row import WorkRow
from ..work.latest_request import LatestRequest

_FOLDER_KEY = "guide/network-folder"
_HEADERS = ("Network", "Maker", "Licence", "Size", "Gives", "State")
GIVES = {
    "relative-inverse": "a value that falls with depth",
    "affine-inverse": "inverse depth up to scale and shift",
    "affine": "depth up to scale and shift",
    "metric": "metric depth",
}
"""What guides give, in words."""


class GuideNetworksDialog(QDialog):
    """Dialog with a row for each network; it is accepted to use the chosen one. Nothing is fetched before *Fetch* is
    pressed, and closing the dialog does not end that.

    Parameters
    ----------
    has_frame : bool
        Whether there is a frame for which a network can be used.
    requests : LatestRequest
        Fetches and adds networks.
    notes : Notes
        Tells what has come of that.
    """

    def __init__(self, parent: QWidget, has_frame: bool, requests: LatestRequest, notes: Notes) -> None:
        super().__init__(parent)
        self._notes = notes
        self.setWindowTitle("Guide by network")
        self._has_frame = has_frame
        self._requests = requests
        self._cards: dict[str, GuideCard] = {}
        about = Message(lines=2)
        about.show_message(
            "A network predicts depth from colour, which is followed where hidden depth is better with it. Nothing is "
            "fetched unasked; networks run on this computer, and images do not leave it.",
            "text",
        )
        self.networks = row_list("Guide networks", "Networks that predict depth from colour", _HEADERS, stretched=2)
        self.networks.setAllColumnsShowFocus(True)
        self.networks.currentItemChanged.connect(lambda *_: self._show_chosen())
        self.message = Message(lines=3)
        self.work = WorkRow("download", "what has come is kept, and Fetch continues")
        self.work.follow(requests)
        requests.begun.connect(self._allow)
        requests.ended.connect(self._allow)
        self.fetch_button = QPushButton("&Fetch")
        self.use_button = QPushButton("&Use as guide")
        self.use_button.setToolTip("Predict a guide of the current frame by the selected network")
        self.add_button = QPushButton("&Add file…")
        self.add_button.setToolTip("Add an ONNX file: one that was copied from another computer, or of your own")
        self.gives = combo(GIVES, "What a network of your own predicts; it is fitted to known depth as that")
        self.fetch_button.clicked.connect(self._fetch)
        self.use_button.clicked.connect(self.accept)
        self.add_button.clicked.connect(self._add)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        buttons.rejected.connect(self.reject)
        ours = row(self.add_button, label_of("A network of your own &gives", self.gives), self.gives)
        chosen = row(self.fetch_button, self.use_button)
        stack(self, about, self.networks, self.message, chosen, self.work, ours, buttons, stretched=self.networks)
        buttons.button(QDialogButtonBox.StandardButton.Close).setDefault(True)  # Enter fetches nothing
        give_size(self, 860, 460)
        self.show_networks()

    def chosen(self) -> str:
        """The name of the selected network; "" for none."""
        item = self.networks.currentItem()
        return "" if item is None else item.text(0)

    def show_networks(self, chosen: str = "") -> None:
        """Show the networks as they are now, and select one; by default the same as before."""
        chosen = chosen or self.chosen()
        self.networks.clear()
        self._cards, damaged = guide_cards()
        for name, card in self._cards.items():
            size = f"{card.bytes / 1e6:.1f} MB"
            item = QTreeWidgetItem([name, card.maker, licence_text(card), size, card.gives, state_of(card)])
            item.setToolTip(4, GIVES[card.gives])
            item.setTextAlignment(3, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.networks.addTopLevelItem(item)
            if name == chosen or self.networks.currentItem() is None:
                self.networks.setCurrentItem(item)
        for error in damaged.values():
            self.message.show_message(error_text(error), "error")

    def _allow(self) -> None:
        card = self._cards.get(self.chosen())
        there = card is not None and guide_file(card.name) is not None
        busy = self._requests.question is not None
        self.fetch_button.setEnabled(card is not None and not there and bool(card.address) and not busy)
        self.use_button.setEnabled(there and self._has_frame)
        self.add_button.setEnabled(not busy)

    def _show_chosen(self) -> None:
        """Tell the licence, and where the network is fetched from, before it is."""
        self._allow()
        card = self._cards.get(self.chosen())
        if card is None:
            return
        there = guide_file(card.name) is not None
        source = f" Fetch gets it from {urlsplit(card.address).hostname}." if card.address and not there else ""
        frame = " Open a frame to use it." if there and not self._has_frame else ""
        licence = f" of {card.maker}: licence {licence_text(card)}" if card.licence else ": a network of your own"
        self.message.show_message(f"{card.name}{licence}.{source}{frame}", "text")

    def _fetch(self) -> None:
        name, progressed = self.chosen(), self._requests.progressed

        def fetch() -> str:
            fetch_guide(name, lambda here, whole: progressed.emit(min(here / max(whole, 1), 1.0)))
            return name

        self._change("Fetch network", fetch)

    def _add(self) -> None:
        if path := choose_file(self, "Add guide network", _FOLDER_KEY, f"ONNX networks (*{NETWORK_SUFFIX})"):
            gives: Gives = self.gives.currentData()
            self._change("Add network", lambda: add_guide(path, gives=gives).stem)

    def _change(self, what: str, find: Callable[[], str]) -> None:
        """Fetch or add a network, whose name `find` returns; the dialog may be closed meanwhile."""

        def take(name: str) -> None:
            self._notes.show_message(f"The guide network {name} is ready.")
            if isValid(self):
                self.show_networks(name)

        def fail(error: Exception) -> None:
            if isValid(self):
                self.message.show_message(error_text(error), "error")
            else:
                self._notes.report(what, error)

        self._requests.ask(find, take, fail, kind=what)
