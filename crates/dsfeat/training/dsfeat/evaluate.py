"""Evaluates a model: IoU and pixel AUC on road scenes; moving, parked and still surfaces on rendered towns.

    python -m dsfeat.evaluate --model hybrid.onnx --cache CACHE --json metrics.json
    python -m dsfeat.evaluate --two --model ../models/dsfeat.onnx --cache CACHE --json metrics.json

With `--two` the sets of `dsfeat.streets` are judged: classes by the second answer, states of real vehicles by the first.

Whole frames are squeezed to the network's input, as the SLAM system does; the activation is brought back to the labels'
size bilinearly. Positive class: static.
"""

import argparse
import json
from pathlib import Path
from typing import Callable

import cv2
import numpy as np
import torch

from .augment import whole
from .data import DYNAMIC, STATIC, TOWN_MOVING, TOWN_PARKED, TOWN_STILL, Scenes, add_folders, load, need
from .metrics import Tally
from .network import DSFeat, restored
from .triplets import VEHICLES
from .two_answers import PIXELS

#: Activation maps [B, 48, 160] of images [B, 1, 96, 320].
Predict = Callable[[np.ndarray], np.ndarray]
ROAD_SCENES = ("cityscapes_val", "idd_val", "camvid_val", "camvid_test", "kitti_val")


def predictor(network: DSFeat) -> Predict:
    """A PyTorch network as a function of arrays, in evaluation mode."""

    def predict(images: np.ndarray) -> np.ndarray:
        with torch.no_grad():
            return network.eval().activation(torch.from_numpy(images))[:, 0].numpy()

    return predict


def onnx_predictor(path: Path) -> Predict:
    """An ONNX model as a function of arrays."""
    from .runtime import session

    model = session(path)
    return lambda images: np.concatenate([model.run(None, {"image": one[None]})[0][0] for one in images])


def activations(predict: Predict, scenes: Scenes, indices: np.ndarray):
    """Yields (index, activation at the labels' size) of the frames at `indices`."""
    rows, cols = scenes.maps.shape[1:]
    for start in range(0, len(indices), 8):
        part = indices[start : start + 8]
        found = predict(np.stack([whole(scenes.images[i]) for i in part])[:, None])
        for i, activation in zip(part, found):
            resized = cv2.resize(activation, (cols, rows), interpolation=cv2.INTER_LINEAR)
            yield i, np.clip(resized, 0.0, 1.0)


def road(predict: Predict, scenes: Scenes, limit: int | None = None) -> dict[str, float]:
    """AUC, IoU and mean activations of static against dynamic pixels (class-based labels)."""
    tally = Tally()
    for i, activation in activations(predict, scenes, chosen(scenes, limit)):
        tally.add(activation, scenes.maps[i] == STATIC, scenes.maps[i] == DYNAMIC)
    iou_static, iou_dynamic = tally.iou()
    mean_static, mean_dynamic = tally.means()
    return {
        "auc": tally.auc(), "iou_static": iou_static, "iou_dynamic": iou_dynamic,
        "mean_iou": 0.5 * (iou_static + iou_dynamic), "mean_static": mean_static, "mean_dynamic": mean_dynamic,
    }


def town(predict: Predict, scenes: Scenes, limit: int | None = None) -> dict[str, float]:
    """AUCs and mean activations of moving, parked and still surfaces (exact masks, without the sky)."""
    parked, still, both = Tally(), Tally(), Tally()
    for i, activation in activations(predict, scenes, chosen(scenes, limit)):
        labels = scenes.labels[i]
        parked.add(activation, labels == TOWN_PARKED, labels == TOWN_MOVING)
        still.add(activation, labels == TOWN_STILL, labels == TOWN_MOVING)
        both.add(activation, labels == TOWN_STILL, labels == TOWN_PARKED)
    return {
        "auc_parked_moving": parked.auc(), "auc_still_moving": still.auc(), "auc_still_parked": both.auc(),
        "mean_moving": parked.means()[1], "mean_parked": parked.means()[0], "mean_still": still.means()[0],
    }


def vehicles(predict: Predict, path: Path) -> dict[str, dict[str, float]]:
    """Standing against moving points on vehicles of real sequences (labels by motion, `dsfeat.prepare vehicles`)."""
    with np.load(path) as file:
        data = {k: file[k] for k in file.files}
    found = {}
    for number, name in enumerate(data["names"]):
        tally = Tally()
        for i in np.flatnonzero(data["source"] == number):
            activation = predict(data["images"][i].astype(np.float32)[None, None] / 255.0)[0]
            scale = np.array(activation.shape[::-1]) / 2.0
            x, y = ((data["points"][i] + 1.0) * scale - 0.5).T.astype(np.float32)
            values = cv2.remap(activation, x[None], y[None], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)[0]
            tally.add(np.clip(values, 0.0, 1.0), data["labels"][i] == 1, data["labels"][i] == 0)
        standing, moving = tally.means()
        found[f"vehicles_{name}"] = {"auc_standing_moving": tally.auc(), "mean_standing": standing, "mean_moving": moving}
    return found


def chosen(scenes: Scenes, limit: int | None) -> np.ndarray:
    """All frames, or `limit` evenly spread ones."""
    count = len(scenes) if limit is None else min(limit, len(scenes))
    return np.linspace(0, len(scenes) - 1, count).round().astype(int)


def quick(network: DSFeat, watched: list[Scenes], limit: int = 16) -> dict[str, float]:
    """A few numbers of a few frames, for the training curves."""
    predict = predictor(network)
    found: dict[str, float] = {}
    for scenes in watched:
        if scenes.name.startswith("town_"):
            result = town(predict, scenes, limit)
            found[f"{scenes.name}:auc_parked_moving"] = result["auc_parked_moving"]
            found[f"{scenes.name}:mean_parked"] = result["mean_parked"]
            found[f"{scenes.name}:mean_moving"] = result["mean_moving"]
        else:
            found[f"{scenes.name}:auc"] = road(predict, scenes, limit)["auc"]
    return found


def evaluate(predict: Predict, cache: Path) -> dict[str, dict[str, float]]:
    """All validation sets in the cache."""
    found = {name: road(predict, load(name, cache)) for name in ROAD_SCENES if (cache / f"{name}.npz").is_file()}
    for path in sorted(cache.glob("town_*_9??.npz")):
        found[path.stem] = town(predict, load(path.stem, cache))
    if (cache / VEHICLES).is_file():
        found.update(vehicles(predict, cache / VEHICLES))
    return found


def evaluate_two(args: argparse.Namespace) -> dict[str, dict[str, float]]:
    """The sets of `dsfeat.streets`, of an ONNX model or a checkpoint; `--hidden` adds the hand-made test labels."""
    from . import two_evaluate
    from .train_two import starting

    if args.model.suffix == ".pt":
        predict = two_evaluate.predictor(starting(args.model), PIXELS[args.size], known=not args.all_known)
    else:
        predict = two_evaluate.onnx_predictor(args.model, PIXELS[args.size])
    if args.hidden:
        return {"kitti_semantics5": two_evaluate.hidden(predict, args.training)}
    return two_evaluate.evaluate(predict, args.cache, args.third)


def rounded(found: dict[str, dict[str, float]]) -> dict[str, dict[str, float | None]]:
    """Four digits of each number; `None` where a set has no pixels of a kind, for JSON knows no NaN."""
    return {n: {k: round(v, 4) if np.isfinite(v) else None for k, v in values.items()} for n, values in found.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", type=Path, required=True, help="ONNX model, or checkpoint of dsfeat.train (.pt)")
    parser.add_argument("--json", type=Path, help="file to write the numbers to")
    parser.add_argument("--two", action="store_true", help="a network with two answers (`dsfeat.train_two`)")
    parser.add_argument("--third", type=int, choices=(0, 1, 2), help="with --two: judge this third of the drives, not trained on")
    parser.add_argument("--size", choices=sorted(PIXELS), default="large", help="with --two: the preset")
    parser.add_argument("--all-known", action="store_true", help="with --two: a checkpoint without a fit of `known`")
    parser.add_argument("--hidden", action="store_true", help="with --two: only the test frames `kitti_semantics5`")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "cache")
    torch.set_num_threads(1)
    if args.two:
        found = evaluate_two(args)
    elif args.model.suffix == ".pt":
        found = evaluate(predictor(restored(args.model)), args.cache)
    else:
        found = evaluate(onnx_predictor(args.model), args.cache)
    for name, values in found.items():
        print(f"{name:20}", " ".join(f"{k} {v:.3f}" for k, v in values.items()))
    if args.json:
        args.json.write_text(json.dumps(rounded(found), indent=1, allow_nan=False) + "\n")


if __name__ == "__main__":
    main()
