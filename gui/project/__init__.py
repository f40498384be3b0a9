"""What the window keeps of its project: the journal, what is stored of frames, and which project it is."""
