"""Exports the network with two answers to ONNX and compares ONNX Runtime's outputs with PyTorch's.

    python -m dsfeat.two_export --checkpoint runs/two/known.pt --out ../models/dsfeat.onnx
"""

import argparse
import time
from pathlib import Path

import numpy as np
import onnx
import torch

from .export import OPSET, TOLERANCE
from .network import multiply_adds
from .runtime import session
from .train_two import starting
from .two_answers import PIXELS, Exported, TwoAnswers, size_for

#: Aspect of a KITTI frame.
WIDE = 1241 / 376
OUTPUTS = ["activation", "lasting", "known"]


def export_onnx(network: TwoAnswers, path: Path) -> None:
    """Writes `network`: `image` float32 [1, 1, H, W] in 0..1 -> `activation`, `lasting` [1, 1, H/2, W/2], `known` [1, 1, 1, 1].

    H and W are left open; they must be multiples of `two_answers.UNIT`.
    """
    names = {name: {2: f"{name}_rows", 3: f"{name}_columns"} for name in ("image", "activation", "lasting")}
    torch.onnx.export(
        Exported(network).eval(), (torch.zeros(1, 1, *size_for(2.0)),), str(path), input_names=["image"], output_names=OUTPUTS,
        opset_version=OPSET, dynamic_axes=names, dynamo=False,
    )
    model = onnx.load(str(path))
    onnx.checker.check_model(model)
    del model.metadata_props[:]
    onnx.save(model, str(path))


def compare(network: TwoAnswers, path: Path, size: tuple[int, int]) -> float:
    """Largest difference of any output between PyTorch and ONNX Runtime on random images of several roughnesses."""
    rng, model, worst = np.random.default_rng(0), session(path), 0.0
    for i in range(5):
        coarse = rng.random((1, 1, size[0] >> i, size[1] >> i), dtype=np.float32)
        image = np.repeat(np.repeat(coarse, 1 << i, axis=2), 1 << i, axis=3)
        with torch.no_grad():
            expected = network.eval()(torch.from_numpy(image)).answers()
        found = model.run(OUTPUTS, {"image": image})
        worst = max(worst, *(float(np.abs(f - e.numpy()).max()) for f, e in zip(found, expected)))
    return worst


def milliseconds(path: Path, size: tuple[int, int], runs: int = 60) -> float:
    """Processor time of the fastest of `runs` inferences on one thread."""
    model, image, best = session(path), np.random.default_rng(1).random((1, 1, *size), dtype=np.float32), float("inf")
    for _ in range(runs):
        start = time.process_time()
        model.run(None, {"image": image})
        best = min(best, time.process_time() - start)
    return 1e3 * best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checkpoint", type=Path, required=True, help="checkpoint of dsfeat.train_two or dsfeat.known")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    args = parser.parse_args()
    torch.set_num_threads(1)
    network = starting(args.checkpoint).eval()
    export_onnx(network, args.out)
    parameters = sum(p.numel() for p in network.parameters())
    print(f"{args.out}: {args.out.stat().st_size} bytes, {parameters} parameters")
    difference = 0.0
    for name, pixels in PIXELS.items():
        for aspect in (WIDE, 4 / 3):
            size = size_for(aspect, pixels)
            difference = max(difference, compare(network, args.out, size))
            cost = f"{2e-9 * multiply_adds(network, *size):.3f} GFLOP, {milliseconds(args.out, size):.2f} ms on one thread"
            print(f"{name}: {size[0]} x {size[1]}, {cost}")
    print(f"largest difference from PyTorch {difference:.1e}")
    if difference > TOLERANCE:
        raise SystemExit(f"ONNX Runtime differs from PyTorch by {difference:.1e}, more than {TOLERANCE:.0e}")


if __name__ == "__main__":
    main()
