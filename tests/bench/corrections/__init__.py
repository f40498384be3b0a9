"""Twelve wrong boundaries on real frames, corrected in the real window.

`python -m tests.bench.corrections --with tools`, or brush. `corrections.json` says what is wrong, and what was wanted,
drawn by hand over the colour images. A way of correcting them (`brush.py`, `tools.py`) is a list of actions for each,
by its name; another way is another such module, named in `WAYS`. Tool and brush stay in hand from one correction to the
next; each finds its frame as it was extracted, nothing chosen, its region in view.
"""
