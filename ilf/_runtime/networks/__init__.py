"""ONNX networks: their files, and running them with cancellation."""
