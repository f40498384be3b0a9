"""ONNX networks: which there are, and running one so that it can be cancelled."""
