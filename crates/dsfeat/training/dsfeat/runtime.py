"""ONNX Runtime on one thread."""

from pathlib import Path

import onnxruntime as ort


def session(path: Path) -> ort.InferenceSession:
    """Opens an ONNX model on one thread."""
    options = ort.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    return ort.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
