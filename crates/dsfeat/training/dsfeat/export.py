"""Exports a checkpoint to ONNX and compares ONNX Runtime's output with PyTorch's.

    python -m dsfeat.export --checkpoint runs/hybrid/last.pt --out hybrid.onnx
"""

import argparse
import time
from pathlib import Path

import numpy as np
import onnx
import torch

from .network import HEIGHT, WIDTH, DSFeat, Exported, multiply_adds, restored
from .runtime import session

#: ONNX operator set: the newest that pure-Rust runtimes read well.
OPSET = 13
#: Largest difference of an activation between PyTorch and ONNX Runtime that is accepted.
TOLERANCE = 1e-4


def export_onnx(network: DSFeat, path: Path) -> None:
    """Writes `network` as ONNX: `image` float32 [1, 1, 96, 320] in 0..1 -> `activation` [1, 1, 48, 160]."""
    torch.onnx.export(
        Exported(network).eval(),
        (torch.zeros(1, 1, HEIGHT, WIDTH),),
        str(path),
        input_names=["image"],
        output_names=["activation"],
        opset_version=OPSET,
        dynamo=False,
    )
    model = onnx.load(str(path))
    onnx.checker.check_model(model)
    del model.metadata_props[:]
    onnx.save(model, str(path))


def compare(network: DSFeat, path: Path, seed: int = 0, images: int = 8) -> float:
    """Largest difference between PyTorch and ONNX Runtime on `images` random images of several roughnesses."""
    rng = np.random.default_rng(seed)
    model = session(path)
    worst = 0.0
    for i in range(images):
        coarse = rng.random((1, 1, HEIGHT >> (i % 4), WIDTH >> (i % 4)), dtype=np.float32)
        image = np.repeat(np.repeat(coarse, 1 << (i % 4), axis=2), 1 << (i % 4), axis=3)
        with torch.no_grad():
            expected = network.eval().activation(torch.from_numpy(image)).numpy()
        worst = max(worst, float(np.abs(model.run(None, {"image": image})[0] - expected).max()))
    return worst


def milliseconds(path: Path, runs: int = 60) -> float:
    """Processor time of the fastest of `runs` inferences on one thread."""
    model = session(path)
    image = np.random.default_rng(1).random((1, 1, HEIGHT, WIDTH), dtype=np.float32)
    best = float("inf")
    for _ in range(runs):
        start = time.process_time()
        model.run(None, {"image": image})
        best = min(best, time.process_time() - start)
    return 1e3 * best


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checkpoint", type=Path, help="checkpoint of dsfeat.train; without it an untrained network")
    parser.add_argument("--out", type=Path, required=True, help="ONNX file to write")
    parser.add_argument("--seed", type=int, default=0, help="seed of an untrained network's weights")
    args = parser.parse_args()
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)
    network = restored(args.checkpoint) if args.checkpoint else DSFeat()
    export_onnx(network, args.out)
    difference = compare(network, args.out)
    parameters = sum(p.numel() for p in network.parameters())
    print(f"{args.out}: {args.out.stat().st_size} bytes, {parameters} parameters, "
          f"{2e-9 * multiply_adds(network):.3f} GFLOP, {milliseconds(args.out):.2f} ms on one thread, "
          f"largest difference from PyTorch {difference:.1e}")
    if difference > TOLERANCE:
        raise SystemExit(f"ONNX Runtime differs from PyTorch by {difference:.1e}, more than {TOLERANCE:.0e}")


if __name__ == "__main__":
    main()
