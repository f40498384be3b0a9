"""What the process itself needs: cancellation, threads, processes, files, optional packages, networks."""
