"""What is passed around in the library cannot be changed by who gets it, and can be compared without surprises."""

import dataclasses
import importlib
import pkgutil
import types

import numpy as np

import ilf
from ilf.io.cameras import intrinsics_from
from ilf.sources.frame_ref import ReadingOptions

BUILT_UP = {"ilf.batch.engine.Counts"}
"""Those that are filled step by step, and seen by nobody else meanwhile."""

OWNED = {"ilf.project.run_history.StoredRun", "ilf.stream.stream.StreamStatistics"}
"""Those that one owner works on, and gives copies of."""


COMPARABLE = {"ilf.sources.frame_ref.ReadingOptions"}
"""Those that turn arrays into tuples."""


def library_modules() -> list[types.ModuleType]:
    names = (module.name for module in pkgutil.walk_packages(ilf.__path__, "ilf."))
    apart = ("__main__", ".training", "ilf.torch")  # the last two need PyTorch
    return [importlib.import_module(name) for name in names if not any(part in name for part in apart)]


CLASSES = {
    f"{module.__name__}.{name}": item
    for module in library_modules()
    for name, item in vars(module).items()
    if isinstance(item, type) and dataclasses.is_dataclass(item) and item.__module__ == module.__name__
}


def test_it_cannot_be_changed():
    changeable = {name for name, item in CLASSES.items() if not item.__dataclass_params__.frozen}
    assert changeable <= BUILT_UP | OWNED


def kinds_of(name):
    """What the fields are annotated with, in full; names that only type checkers import stay as they are."""
    module = vars(importlib.import_module(CLASSES[name].__module__))
    for field in dataclasses.fields(CLASSES[name]):
        try:
            yield str(eval(str(field.type), dict(module)))
        except NameError:
            yield str(field.type)


def test_reading_options_with_a_camera_matrix_can_be_compared():
    camera = np.diag([500.0, 500.0, 1.0])
    assert ReadingOptions(intrinsics=camera) == ReadingOptions(intrinsics=camera.copy())
    assert intrinsics_from(ReadingOptions(intrinsics=camera).intrinsics) == intrinsics_from(camera)


def test_what_holds_arrays_has_no_comparison_that_asks_them_for_one_truth():
    compared = {name for name, item in CLASSES.items() if item.__dataclass_params__.eq}
    of_arrays = {name for name in compared if any("ndarray" in k and "Callable" not in k for k in kinds_of(name))}
    assert of_arrays <= BUILT_UP | COMPARABLE
