"""ILF Studio's library: complete the missing depth in RGB-D frames by iterative low-pass filtering.

    frame = ilf.load_frame("room")
    completion = ilf.complete(frame)
    completion.save("room-done")

Names are imported when they are first used, from where `__init__.pyi` says: all of them take a second.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
