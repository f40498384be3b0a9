"""Reports: dialog, writing in the background, and PDF layout."""
