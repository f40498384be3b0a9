"""ILF Studio's library: complete the missing depth in RGB-D frames by iterative low-pass filtering.

    frame = ilf.load_frame("room")
    completion = ilf.complete(frame)
    completion.save("room-done")

Names are imported on first use, from the modules listed in `__init__.pyi`: importing all of them takes a second.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
