"""A frame is measured, checked and looked at."""

from ..hand import Hand


def profile_along_a_line(user: Hand) -> None:
    """The depth along a line as a table and a picture, in pixels and metres; the line removed and drawn again."""
    user.tool("profile")
    user.drag([(20, 30), (140, 90)])
    with user.answering(user.folder / "profile.csv"):
        user.do("save_profile")
    user.keep("profile", user.folder / "profile.csv")
    with user.answering(user.folder / "profile.svg"):
        user.do("save_profile_picture")
    user.keep("picture was written", (user.folder / "profile.svg").stat().st_size > 0)
    user.fill("Unit of the horizontal axis of the profile", "Pixels", user.panel("Inspect", "Profile"))
    user.do("remove_marks")
    user.keep_project("removed")
    user.tool("profile")
    user.drag([(80, 10), (80, 110)])


def statistics_of_a_rectangle(user: Hand) -> None:
    """Copied for a rectangle and for a block."""
    user.tool("rectangle")
    user.drag([(20, 30), (100, 90)])
    user.do("copy_statistics")
    user.keep("statistics of the rectangle", user.copied())
    user.select((40, 30))
    user.fill("Region of the statistics", "Selected block", user.panel("Inspect", "Statistics"))
    user.do("copy_statistics")
    user.keep("statistics of the block", user.copied())


def measure_lengths_and_angles(user: Hand) -> None:
    """Two lines, copied, written, deleted and restored."""
    user.tool("measure")
    for chain in (((20, 30), (60, 40), (60, 80)), ((100, 40), (130, 90))):
        for point in chain:
            user.click(point)
        user.key("Return")
    user.do("copy_measurements")
    user.keep("measurements", user.copied())
    with user.answering(user.folder / "lengths.csv"):
        user.do("save_measurements")
    user.keep("measurements written", user.folder / "lengths.csv")
    user.do("delete_measurements")
    user.keep_project("deleted")
    user.do("restore_measurements")


def quality_checks(user: Hand) -> None:
    """Gone through forwards and back; one remedied, one ignored; then closed."""
    user.tool("select")
    user.do("next_check")
    user.do("next_check")
    user.do("previous_check")
    user.do("apply_remedy")
    user.do("next_check")
    user.do("ignore_check")
    user.panel("Quality").close()


def suggested_invalid_depth(user: Hand) -> None:
    """Rejected at first, then taken."""
    user.do("suggest_invalid")
    user.do("ignore_check")
    user.keep_project("rejected")
    user.do("suggest_invalid")
    user.do("apply_remedy")


def colours_of_depth(user: Hand) -> None:
    """The range of the colours: typed, locked, fitted to a rectangle; another colour map."""
    user.do("show_range")
    panel = user.panel("Range")
    user.fill("Lower limit of the colour range", 1.5, panel)
    user.fill("Upper limit of the colour range", 3.5, panel)
    user.do("lock_range")
    user.do("lock_range")
    user.tool("rectangle")
    user.drag([(20, 30), (100, 90)])
    user.do("fit_range")
    limits = [f"{side} limit of the colour range" for side in ("Lower", "Upper")]
    user.keep("range", [user.control(name, panel).text() for name in limits])
    user.choose("View", "Depth colours", "Turbo")


def arrange_views(user: Hand) -> None:
    """All view sets, the cloud, overlays, full screen and the panels; an own layout saved, renamed and deleted."""
    for name in ("contours_only", "block_names", "show_missing", "cloud_raw", "cloud_selected_only"):
        user.do(name)
        user.do(name)
    user.do("cloud_beside")
    user.do("cloud_beside")
    for name in ("Four views", "Two compared", "One large, three small", "Extraction", "Colour + blocks"):
        user.choose("View", "View set", name)
    user.do("view_content")
    user.key("Escape")
    user.do("reset_contents")
    for name in ("full_screen", "toggle_panels", "film_strip"):
        user.do(name)
        user.do(name)
    for name in ("layout_inspect", "layout_correct", "layout_tune", "layout_standard"):
        user.do(name)
    user.start("save_layout")
    user.answer("Save layout as", "Mine")
    user.start("rename_layout")
    user.answer("Rename layout", "Ours")
    user.do("reset_layout")
    user.do("delete_layout")
    user.do("restore_layout")
    user.do("fit")
    user.do("one_to_one")
    user.choose("View", "Theme", "Dark")
    user.choose("View", "Theme", "Light")
    with user.answering(user.folder / "window.png"):
        user.do("save_picture")
    user.keep("picture was written", (user.folder / "window.png").stat().st_size > 0)
    for name in ("only_icons", "next_tool", "previous_tool", "only_icons"):
        user.do(name)


def find_a_command(user: Hand) -> None:
    """Through the palette; with keys of one's own; and who made this."""
    user.do("palette")
    user.control("Command").setFocus()
    user.write("select all blocks")
    user.settle()
    dialog = user.dialog("Keyboard shortcuts", "shortcuts")
    user.fill("Filter", "Merge", dialog)
    user.click_row("Commands and their keys", 0, within=dialog)
    user.press("None", dialog)
    user.press("Reset all", dialog)
    dialog.close()
    about = user.dialog("About ILF Studio", "about")
    user.press("Copy versions", about)
    user.keep("versions were copied", "ILF Studio" in user.copied())
    user.press("Close", about)
    user.keep("log", user.panel("Log").isVisible())
