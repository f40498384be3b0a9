"""Work off the window's thread: jobs, questions of which the latest counts, runs, the loading of frames."""
