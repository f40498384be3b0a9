"""Wrong boundaries on real frames, corrected in the real window: twelve, and twelve others.

`python -m tests.bench.corrections --with tools`, or another of the `WAYS`. `corrections.json` and `second.json` have
the wrong boundaries and the targets, drawn by hand over the colour images. A way of correcting them (in `brush.py`,
`tools.py`, `second.py`) is a list of actions for each correction, by its name. Tool and brush stay active from one
correction to the next; each correction starts with the extracted blocks, no selection, and its region in view.
"""
