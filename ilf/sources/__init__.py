"""Where frames come from: folders, data sets, recordings and cameras, behind one interface."""
