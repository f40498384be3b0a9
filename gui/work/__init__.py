"""Background work: worker threads, job queues, runs, and deferred refresh of widgets."""
