"""Many frames: completed by several processes or machines, a folder each; started again, a batch resumes."""
