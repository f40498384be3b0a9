"""
Complete a frame
================

The bundled sample is a generated room with the noise and the holes of a Kinect. This script completes its depth and
writes the results.
"""

import ilf
from ilf.cli import main

main(["sample", "room"])  # in a terminal: ilf sample room

frame = ilf.load_frame("room")
frame

# %%
# `ilf.complete` extracts operation blocks, closed regions of one surface each, and completes the depth of each block.

completion = ilf.complete(frame)
print(completion)
completion.plot()

# %%
# The expected error tells how far a filled pixel may be off: over many frames, about 68 % of the true errors lie
# within it.

completion.plot_error()

# %%
# The files are those of ``ilf complete room --out done``.

written = completion.save("done")
print(*(path.name for path in written.files), sep="\n")
