"""Blocks are corrected by tools and commands."""

from ..hand import Hand


def redraw_a_border(user: Hand) -> None:
    """Drawn, adjusted at its middle, taken; a second one given up by Escape; snapped to edges by the leash."""
    user.tool("border")
    user.fill("Snap", 0)
    user.drag([(52, 20), (60, 34), (60, 50), (50, 64)])
    user.drag([(60, 40), (66, 42)])
    user.key("Return")
    user.fill("Snap", 12)
    user.drag([(90, 30), (98, 44), (92, 60)])
    user.key("Return")
    user.drag([(52, 20), (44, 40), (50, 64)])
    user.key("Escape")


def refine_an_edge(user: Hand) -> None:
    user.tool("border")
    user.fill("Snap", 0)
    user.drag([(52, 20), (62, 34), (62, 50), (50, 64)])
    user.key("Return")
    user.tool("refine")
    user.fill("Brush", 6)
    user.drag([(60, 30), (62, 42), (60, 52)])


def outline_a_block(user: Hand) -> None:
    """By clicks with one taken back, and by a free line; both in no block that is selected."""
    user.tool("outline")
    user.fill("Snap", 0)
    for corner in ((20, 20), (60, 22), (58, 50), (30, 55), (5, 5)):
        user.click(corner)
    user.key("Backspace")
    user.key("Return")
    user.key("Return")
    user.do("cancel_stroke")
    user.drag([(100, 70), (130, 70), (130, 95), (105, 100), (100, 71)])


def smart_select(user: Hand) -> None:
    """A click, a further one, one that takes away, a step to the object; then a box; then a stroke to the block."""
    user.tool("smart_select")
    user.hover((40, 30))
    user.click((40, 30))
    user.click((52, 36), "Shift")
    user.click((80, 90), "Alt")
    user.wheel((40, 30), 1, "Ctrl")
    user.key("Return")
    user.key("Escape")
    user.drag([(90, 40), (130, 80)])
    user.key("Return")
    user.drag([(100, 60), (120, 64)], "Shift")
    user.click((110, 62), "Alt")
    user.key("Backspace")
    user.key("Return")


def split_a_block(user: Hand) -> None:
    """Along a line, and where a click suggests it."""
    user.tool("split")
    user.fill("Snap", 0)
    user.drag([(2, 60), (80, 62), (158, 60)])
    user.do("select_all")
    user.do("merge_blocks")
    user.tool("split")
    user.click((40, 30))
    user.key("Return")


def paint_and_erase(user: Hand) -> None:
    """Brushes of several sizes, similar pixels alone, to no block."""
    user.select((40, 30))
    user.tool("paint")
    user.fill("Brush", 5)
    user.drag([(60, 40), (75, 50), (80, 60)])
    user.do("brush_larger")
    user.drag([(20, 80), (40, 90)])
    user.do("similar_only")
    user.drag([(90, 30), (110, 50)])
    user.do("similar_only")
    user.tool("erase")
    user.do("brush_smaller")
    user.drag([(30, 20), (40, 36)])
    user.do("to_no_block")
    user.wheel((30, 30), 1, "Ctrl")
    user.drag([(20, 30), (36, 44)])


def give_pieces(user: Hand) -> None:
    user.tool("give")
    user.click((40, 30))
    user.hover((110, 90))
    user.click((110, 90))


def mark_depth_invalid(user: Hand) -> None:
    """Marked, partly taken back, undone and done again."""
    user.tool("mark_invalid")
    user.fill("Brush", 4)
    user.drag([(40, 30), (70, 40)])
    user.drag([(40, 30), (50, 34)], "Alt")
    user.drag([(100, 90), (110, 92)])
    user.do("undo")
    user.do("undo")
    user.do("redo")


def depth_by_hand(user: Hand) -> None:
    """Picked, painted, typed and filled; planes and surfaces proposed, taken, limited and dropped; removed."""
    user.tool("depth_by_hand")
    user.click((40, 30), "Alt")
    user.fill("Brush", 8)
    user.drag([(20, 20), (60, 40), (120, 60), (140, 100)])
    user.select((40, 30))
    user.do("continue_plane")
    user.key("Return")
    user.do("undo")
    user.do("nearer_surface")
    user.key("Return")
    user.do("farther_surface")
    user.key("Escape")
    user.keep_project("surfaces")
    user.do("remove_by_hand")
    user.tool("depth_by_hand")
    user.fill("Depth", "1.25")
    user.do("fill_by_hand")


def select_and_arrange_blocks(user: Hand) -> None:
    """A band, the table, locks, eyes, colours and names; merged, deleted, made new and cleaned."""
    user.tool("select")
    user.drag([(10, 10), (60, 60)])
    user.click((110, 90), "Shift")
    user.do("lock_blocks")
    user.do("hide_blocks")
    blocks = user.panel("Blocks")
    user.click_row("Blocks", 1, "Shown", within=blocks)
    user.click_row("Blocks", 2, "Locked", within=blocks)
    with user.answering((200, 30, 60)):
        user.click_row("Blocks", 2, "Colour", within=blocks)
    user.click_row("Blocks", 4, "Name", within=blocks)
    user.key("F2")
    user.write("Lamp")
    user.do("select_all")
    user.do("zoom_block")
    user.do("hide_blocks")
    user.do("lock_blocks")
    user.do("lock_blocks")
    user.click((40, 30))
    user.click((110, 90), "Shift")
    user.do("merge_blocks")
    user.click((80, 100))
    user.do("delete_blocks")
    user.do("new_block")
    user.do("shuffle_colours")
    user.do("undo")  # the colours are drawn by chance


def grow_shrink_and_smooth(user: Hand) -> None:
    user.tool("select")
    user.fill("Amount", 3)
    user.click((40, 30))
    user.do("grow_blocks")
    user.click((110, 90))
    user.do("shrink_blocks")
    user.click((80, 60))
    user.fill("Amount", 2)
    user.do("smooth_blocks")
    user.do("clean_up")


def undo_and_go_another_way(user: Hand) -> None:
    """Three strokes, back to the first by key and command, forth once, and a new stroke instead of the third."""
    user.select((40, 30))
    user.tool("paint")
    for row in (60, 75, 90):
        user.drag([(60, row), (100, row)])
    user.key("Ctrl+Z")
    user.do("undo")
    user.do("redo")
    user.do("show_before_edit")
    user.drag([(120, 40), (140, 90)])
    user.drag([(20, 100), (40, 100)], release=False)
    user.do("cancel_stroke")
