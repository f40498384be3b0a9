"""The panel of the colour range."""

import numpy as np
from PySide6.QtGui import QAction

from gui.features.colour_range import RangePanel
from gui.views.colours import Range


def test_a_range_can_be_typed_unless_it_is_locked_or_there_is_none(qtbot):
    panel = RangePanel([QAction("Lock")])
    qtbot.addWidget(panel)
    fields = panel.mode, panel.low, panel.high
    values = np.linspace(1.0, 3.0, 100)
    panel.show_range("Depth in", "depth", values, (1.2, 2.5), Range())
    assert panel.title.text() == "Depth in [m]"
    assert (panel.low.value(), panel.high.value()) == (1.2, 2.5)
    assert all(field.isEnabled() for field in fields)
    panel.show_range("Depth in", "depth", values, (1.2, 2.5), Range(locked=True))
    assert not any(field.isEnabled() for field in fields)
    panel.show_placeholder("Colour", "It has no range.")
    assert not any(field.isEnabled() for field in fields)
