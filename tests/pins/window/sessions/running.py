"""Depth is completed, with parameters of all kinds; runs are kept, compared and exported."""

import csv

from ..frames import guide, guide_network, true_depth
from ..hand import Hand


def export_everything(user: Hand) -> None:
    """A run by the default preset, and all files that the dialog offers."""
    user.do("run_all")
    for cloud, mesh in (("PLY", "PLY"), ("PCD", "GLB")):
        boxes = ("PNG, 16 bit", "TIFF, float32 metres", "NPY, float32 metres", "Write the point cloud", "Normals")
        boxes += ("Expected error as well (expected_error.*)", "Write a mesh, cut where depth jumps")
        values = {"Folder": user.folder / f"out-{cloud}"} | dict.fromkeys(boxes, True)
        values |= {"Format of the point cloud": cloud, "Format of the mesh": mesh}
        user.use_dialog("Export room", "export", values, "Export", "Close")
        user.keep(f"export {cloud}", user.folder / f"out-{cloud}")


def run_selected_blocks_with_own_parameters(user: Hand) -> None:
    """One block has own parameters, another takes them over, a third is set back."""
    user.set_filter("paper", 40)
    user.select((40, 30))
    user.fill("Parameters for", "Block 2")
    user.fill("Padding", 3)
    user.do("run_selected")
    user.keep_project("own")
    user.click((110, 90), "Shift")
    user.do("copy_own")
    user.do("run")
    user.click((40, 30))
    user.do("reset_own")
    user.do("run")


def presets_of_the_user(user: Hand) -> None:
    """Saved with the extraction's parameters, renamed, written, deleted and read again."""
    user.set_filter("paper", 25)
    named = {"Name": "Kitchen", "Include the parameters of the tab Extraction": True}
    user.use_dialog("Save preset", "save_preset", named, "Save")
    with user.answering("Hall"):
        user.do("rename_preset")
    with user.answering(user.folder / "hall.json"):
        user.do("export_preset")
    user.keep("preset", user.folder / "hall.json")
    user.do("delete_preset")
    user.press("Delete", user.dialog("Delete preset"))
    with user.answering(user.folder / "hall.json"):
        user.do("import_preset")
    user.fill("Preset", "best")
    user.fill("Preset", "hall")


def step_pause_and_cancel(user: Hand) -> None:
    """Two steps of a paused run, its end by cancelling; then a run to the end."""
    user.set_filter("paper", 30)
    user.start("step")
    user.wait(lambda: user.action("step").isEnabled())
    user.start("step")
    user.wait(lambda: user.action("cancel").isEnabled())
    user.do("cancel")
    user.keep_project("cancelled")
    user.start("run_all")
    user.start("pause")
    user.wait(lambda: user.action("step").isEnabled())
    user.do("pause")


def live_follows_every_change(user: Hand) -> None:
    """With results there, a parameter and a stroke solve their blocks anew; without Live they do not."""
    user.set_filter("paper", 40)
    user.do("run_all")
    user.select((40, 30))
    user.fill("Padding", 3)
    user.tool("mark_invalid")
    user.fill("Brush", 5)
    user.drag([(40, 30), (60, 36)])
    user.keep_project("live")
    user.do("try_parameters")
    user.keep_project("tried")
    user.do("live")
    user.drag([(100, 90), (120, 92)])


def extrapolate_the_rest(user: Hand) -> None:
    user.set_filter("paper", 30)
    user.do("run_all")
    user.do("extrapolate")
    user.keep_project("extrapolated")
    user.do("clear_results")


def keep_and_compare_runs(user: Hand) -> None:
    """Three runs: named, noted, ticked, accepted, their parameters restored, exported, deleted."""
    for preset, iterations in (("paper", 20), ("best", 40), ("released-code", 12)):
        user.set_filter(preset, iterations)
        user.do("run_all")
    runs = user.panel("Runs")
    user.keep("runs", len(user.rows("Run history", runs)))
    user.click_row("Run history", 0, "Run", runs)
    user.start("rename_run")
    user.write("of the text")
    user.click_row("Run history", 0, "Run", runs)
    user.start("note_run")
    user.write("smooth walls")
    user.do("compare_runs")
    user.click_row("Run history", 1, "Run", runs)
    user.do("accept_run")
    user.click_row("Run history", 0, "Run", runs)
    user.do("restore_run")
    user.keep_project("restored")
    with user.answering(user.folder / "runs.csv"):
        user.do("export_runs")
    with open(user.folder / "runs.csv", newline="") as table:
        user.keep("table", [[row[name] for name in ("number", "name", "note")] for row in csv.DictReader(table)])
    user.do("delete_runs")
    user.keep_project("deleted")
    user.do("clear_runs")


def compare_two_depths(user: Hand) -> None:
    """Side by side, swapped, swiped, and each side chosen."""
    user.set_filter("paper", 20)
    user.do("run_all")
    user.do("show_runs")
    user.choose("View", "Compare two depths", "Side A", "Ground truth")
    user.choose("View", "Compare two depths", "Side B", "Result")
    user.do("compare_two")
    user.do("swap_sides")
    user.do("blink")
    user.do("blink")
    user.do("swipe")


def look_at_convergence(user: Hand) -> None:
    """The curves of a block, its iterations, and what the panel says of the first and the last."""
    user.set_filter("paper", 20)
    user.do("run_all")
    user.select((40, 30))
    curves = user.panel("Convergence")
    user.fill("Iteration shown", 3, curves)
    user.press("Go to the last iteration", curves)
    user.press("Curves over time", curves)
    user.press("Curves over time", curves)


def errors_against_ground_truth(user: Hand) -> None:
    """The sample's truth, all pixels, none, and that of another file."""
    user.set_filter("paper", 30)
    user.do("run_all")
    accuracy = user.panel("Accuracy")
    user.keep("errors", user.rows("Errors against ground truth", accuracy))
    user.fill("Evaluate", "All pixels", accuracy)
    user.keep("errors of all", user.rows("Errors against ground truth", accuracy))
    user.do("remove_ground_truth")
    user.keep_project("none")
    truth = {"The file with the true depth": true_depth(user.folder)}
    user.use_dialog("Load ground truth for room", "load_ground_truth", truth, "Load")
    user.keep("errors again", user.rows("Errors against ground truth", accuracy))


def errors_on_hidden_depth(user: Hand) -> None:
    """A hold-out test of the current parameters and of a preset."""
    user.set_filter("paper", 20)
    user.use_dialog("Hold-out test of room", "hold_out_test", {"Seeds": 2}, "Test")
    accuracy = user.panel("Accuracy")
    user.keep("errors", user.rows("Hold-out errors", accuracy))


def sweep_a_parameter(user: Hand) -> None:
    """Three values of one parameter, and the best of them taken."""
    user.set_filter("paper", 15)
    window = user.dialog("Sweep", "sweep")
    user.fill("First parameter: parameter", "Padding", window)
    user.fill("First parameter: from", 1.5, window)
    user.fill("First parameter: to", 3, window)
    user.fill("First parameter: values", 3, window)
    user.press("Sweep", window)
    user.press("Apply best", window)
    window.close()


def follow_a_guide(user: Hand) -> None:
    """Loaded by the dialog, followed by a run, seen, removed and brought back."""
    with user.answering(guide(user.folder)):
        user.do("load_guide")
    user.press("What it changes", user.panel("Additional depth"))
    user.do("run_all")
    user.keep_project("guided")
    user.do("remove_guide")
    user.do("undo")


def follow_a_network(user: Hand) -> None:
    """A network of one's own is added from a file, and predicts the guide of a run."""
    dialog = user.dialog("Guide by network", "guide_by_network")
    with user.answering(guide_network(user.folder)):
        user.press("Add file", dialog)
    user.keep("networks", user.rows("Guide networks", dialog)[-1])
    user.press("Use as guide", dialog)
    user.do("run_all")


def replay_a_run(user: Hand) -> None:
    """A run is exported, its record opened by the menu, and run again."""
    user.set_filter("paper", 20)
    user.tool("mark_invalid")
    user.drag([(40, 30), (60, 36)])
    user.do("run_all")
    user.use_dialog("Export room", "export", {"Folder": user.folder / "out"}, "Export", "Close")
    user.use_dialog("Open", "open", {"Path": user.folder / "out" / "run.json"}, "Open")
    user.do("run_all")


def extract_by_other_parameters(user: Hand) -> None:
    """Canny without depth, coarser; a block made by hand stays, then goes, too; the stages are looked at."""
    user.tool("outline")
    user.fill("Snap", 0)
    user.drag([(100, 70), (130, 70), (130, 95), (105, 100), (100, 71)])
    user.panel("Parameters")
    user.tab("Extraction")
    user.fill("Granularity", 0.7)
    user.fill("Smallest block", 2)
    user.fill("Edge detector", "canny")
    user.do("extract")
    user.keep_project("kept")
    user.fill("Keep blocks made by hand", False)
    user.fill("Preview", True)
    user.fill("Granularity", 0.4)
    user.fill("Preview", False)
    user.do("extract")
    for stage in ("stage_strength", "stage_binarised", "stage_dilated", "stage_contracted", "stage_blocks"):
        user.do(stage)


def save_and_load_blocks(user: Hand) -> None:
    """Written in every format, and read from one after all blocks were merged."""
    for name in ("blocks.png", "blocks.coco.json", "blocks.labelme.json"):
        with user.answering(user.folder / name):
            user.do("save_blocks")
        if name.endswith("png"):
            user.keep(name, user.folder / name)
    user.do("select_all")
    user.do("merge_blocks")
    user.use_dialog("Load blocks for room", "load_blocks", {"Blocks": user.folder / "blocks.png"}, "Load")
