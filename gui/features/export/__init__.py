"""Export: frames of the window, completed and written as files, or as one page on all of them."""
