"""Twelve wrong boundaries on real frames, corrected in the real window.

`python -m tests.bench.corrections --with tools`, or brush. `corrections.json` has the wrong boundaries and the targets,
drawn by hand over the colour images. A way of correcting them (`brush.py`, `tools.py`) is a list of actions for each
correction, by its name; `WAYS` lists these modules. Tool and brush stay active from one correction to the next; each
correction starts with the extracted blocks, no selection, and its region in view.
"""
