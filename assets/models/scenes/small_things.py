"""Things that stand on tables and shelves, each about the origin with its lowest point at height 0."""

from __future__ import annotations

from .containers import bag, basket, bottle, can, carton, flowers, holder, potted, vessel
from .devices import cable, desk_lamp, keyboard, laptop, monitor, table_lamp
from .printed import book, books, frame, open_book, papers
from .solids import brick, fruit, pliers, polygon, ring, tool

SMALL = (
    carton, carton, carton, bottle, bottle, can, can, vessel, vessel, vessel, vessel, book, books, books, open_book,
    papers, fruit, brick, brick, tool, tool, pliers, cable, holder, keyboard, monitor, laptop, table_lamp, desk_lamp,
    flowers, potted, potted, bag, polygon, ring, frame, basket,
)  # fmt: skip
LOOSE = (
    carton, carton, carton, bottle, can, can, vessel, book, fruit, brick, brick, tool, tool, pliers, bag, polygon, ring,
)  # fmt: skip
"""Things that may lie in any position."""
