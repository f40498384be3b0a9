"""
State depth where nothing was measured
======================================

A block without enough known depth is not recoverable and stays missing. Depth stated by hand, from a ruler or a
drawing, is a constraint with a weight: it lets the block be completed, and is marked in every result.
"""

import numpy as np

import ilf

rows, columns = np.mgrid[:120, :160]
screen = (rows > 30) & (rows < 90) & (columns > 40) & (columns < 120)
rgb = np.where(screen[..., None], (20, 22, 30), (180, 170, 150)).astype(np.uint8)
depth = np.where(screen, np.nan, 2.0 + 0.002 * columns)  # the black screen returns no light
frame = ilf.RGBDFrame(rgb=rgb, depth=depth, name="screen")
blocks = np.where(screen, 2, 1)

completion = ilf.complete(frame, blocks)
for label, outcome in completion.outcomes.items():
    print(label, outcome.status, outcome.message)

# %%
# Three points of the screen were measured with a ruler: it stands before the wall and is tilted a little. Their plane
# is stated for the rim of the screen.

corners = np.array([[31, 41], [31, 119], [89, 80]])  # row, column
plane = np.linalg.solve(np.column_stack([corners, np.ones(3)]), [1.80, 1.84, 1.74])
rim = screen & ((rows < 35) | (rows > 85) | (columns < 45) | (columns > 115))
stated = np.where(rim, plane[0] * rows + plane[1] * columns + plane[2], np.nan)
completion = ilf.complete(frame, blocks, by_hand=stated)
print(completion)
completion.plot()

# %%
# Everything that follows from it is unsupported by measurements, and says so.

print(f"{ilf.unsupported(completion)[screen].mean():.0%} of the screen is marked as unsupported")
