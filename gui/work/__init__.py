"""Background work: worker threads, job queues, runs, loading of frames, and deferred refresh of widgets."""
