"""A contour network trained on BSDS500, for non-commercial use: `bsds500.onnx`."""
