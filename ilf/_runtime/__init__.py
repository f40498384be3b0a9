"""Infrastructure of the process: cancellation, threads, processes, files, optional packages, networks."""
