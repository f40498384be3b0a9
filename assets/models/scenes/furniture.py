"""Large things that stand on the floor about the origin; their front is towards -z."""

from __future__ import annotations

from .figures import big_plant, floor_lamp, person
from .frames import bicycle, easel, ladder, partition, rack
from .seats import bed, chair, office_chair, sofa, stool
from .storage import bin_, box_pile, cupboard, desk, shelf, table, tub

BY_WALL = (
    cupboard, cupboard, cupboard, shelf, shelf, shelf, sofa, sofa, bed, desk, desk, table, big_plant, floor_lamp,
    box_pile, bicycle, rack, ladder, chair, person, tub,
)  # fmt: skip
"""What stands with its back to a wall."""
FREE = (
    table, table, chair, chair, chair, chair, office_chair, office_chair, stool, person, person, big_plant, floor_lamp,
    box_pile, bin_, tub, rack, easel, sofa, partition,
)  # fmt: skip
"""What stands anywhere."""
