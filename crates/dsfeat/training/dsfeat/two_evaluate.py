"""Evaluates the network with two answers; used by `dsfeat.evaluate --two` and, on a few frames, while it trains.

Whole frames are resized to the network's input, as the program does: to one of their own proportions where the model leaves that
open, else squeezed. The answers are brought back to the labels' size bilinearly. Classes are judged by `lasting`, states by `activation`; the high class is what is static.
"""

from pathlib import Path
from typing import Callable

import cv2
import numpy as np
import torch

from . import streets
from .metrics import Tally
from .streets import MOVING, STANDING, STILL, Frames
from .two_answers import PIXELS, TwoAnswers, size_for
from .views import whole

#: Activation and lasting [B, h, w] of images [B, 1, H, W], and the size of images by the frames' aspect.
Predict = tuple[Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], Callable[[float], tuple[int, int]]]
#: A frame fails where static pixels below one half cover more than this share of it.
COVERED = 0.02
#: Sets with class labels, and with motion labels.
CLASSES = ("cityscapes256_val", "idd_lite_val", "camvid_val", "camvid_test")


def predictor(network: TwoAnswers, pixels: int = PIXELS["large"], known: bool = True) -> Predict:
    """A PyTorch network; without `known` as if every scene were known."""

    def predict(images: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        with torch.no_grad():
            logits = network.eval()(torch.from_numpy(images).contiguous(memory_format=torch.channels_last))
            if not known:
                logits.known = torch.full_like(logits.known, 100.0)
            activation, lasting, _ = logits.answers()
        return activation[:, 0].numpy(), lasting[:, 0].numpy()

    return predict, lambda aspect: size_for(aspect, pixels)


def onnx_predictor(path: Path, pixels: int = PIXELS["large"]) -> Predict:
    """An ONNX model with outputs `activation` and `lasting`; one with a single output gives it twice."""
    from .runtime import session

    model = session(path)
    names = [o.name for o in model.get_outputs()]
    asked = ["activation", "lasting" if "lasting" in names else "activation"]

    def predict(images: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = [model.run(asked, {"image": one[None]}) for one in images]
        return np.stack([f[0][0, 0] for f in found]), np.stack([f[1][0, 0] for f in found])

    sides = model.get_inputs()[0].shape[2:]
    fixed = tuple(sides) if all(isinstance(side, int) for side in sides) else None
    return predict, lambda aspect: fixed or size_for(aspect, pixels)


def answers(predict: Predict, frames: Frames):
    """Yields (codes, activation, lasting) of each frame at the labels' size."""
    rows, columns = frames.codes.shape[1:]
    size = predict[1](frames.aspect)
    for start in range(0, len(frames), 8):
        shown = np.stack([whole(image, size) for image in frames.images[start : start + 8]])[:, None]
        for codes, *maps in zip(frames.codes[start : start + 8], *predict[0](shown)):
            yield codes, *(np.clip(cv2.resize(m, (columns, rows), interpolation=cv2.INTER_LINEAR), 0.0, 1.0) for m in maps)


def classes(predict: Predict, frames: Frames) -> dict[str, float]:
    """AUC and IoU of static against dynamic classes by `lasting`."""
    tally = Tally()
    for codes, _, lasting in answers(predict, frames):
        tally.add(lasting, codes == STILL, codes >= STANDING)
    iou_static, iou_dynamic = tally.iou()
    return {"auc": tally.auc(), "iou_dynamic": iou_dynamic, "mean_iou": 0.5 * (iou_static + iou_dynamic)}


def states(predict: Predict, sets: list[Frames]) -> dict[str, float]:
    """AUCs of moving against standing and static pixels by `activation`, means, frames with too much static called moving."""
    standing, still, failed, count = Tally(), Tally(), 0, 0
    for frames in sets:
        for codes, activation, _ in answers(predict, frames):
            standing.add(activation, codes == STANDING, codes == MOVING)
            still.add(activation, codes == STILL, codes == MOVING)
            failed += float(((codes == STILL) & (activation < 0.5)).mean()) > COVERED
            count += 1
    return {
        "auc_standing_moving": standing.auc(), "auc_still_moving": still.auc(), "mean_moving": standing.means()[1],
        "mean_standing": standing.means()[0], "mean_still": still.means()[0], "failed_frames": failed / max(count, 1),
        "moving_below_half": below(still.low), "standing_below_half": below(standing.high), "still_below_half": below(still.high),
    }


def below(histogram: np.ndarray, threshold: float = 0.5) -> float:
    """Share of the pixels of a `Tally`'s histogram that lie below the threshold."""
    return float(histogram[: round(threshold * len(histogram))].sum() / max(histogram.sum(), 1))


def hidden(predict: Predict, training: Path) -> dict[str, float]:
    """`classes` on the hand-made labels of KITTI 2015 (Cityscapes ids): a test set, to be looked at once, at the end."""
    table = np.full(256, STILL, np.uint8)
    table[:7], table[255] = streets.IGNORED, streets.IGNORED
    table[[24, 25, 26, 27, 28, 31, 32, 33]] = streets.VEHICLE
    labels = sorted((training / "kitti_semantics5" / "label").glob("*.webp"))
    rows = [(p.parent.parent / "image" / p.name, table[streets.read_classes(p)], p.stem) for p in labels]
    return classes(predict, streets.collect("kitti_semantics5", "kitti", rows))


def few(frames: Frames, limit: int) -> Frames:
    """At most `limit` evenly spread frames."""
    return frames.of(np.linspace(0, len(frames) - 1, min(limit, len(frames))).round().astype(int))


def quick(network: TwoAnswers, watched: list[Frames], limit: int = 20) -> dict[str, float]:
    """A few numbers of a few frames, while training."""
    predict, found = predictor(network, known=False), {}
    for frames in watched:
        some = few(frames, limit)
        if (some.codes == STANDING).any():
            result = states(predict, [some])
            found.update({f"{frames.name}:{k}": result[k] for k in ("auc_standing_moving", "auc_still_moving")})
        else:
            result = classes(predict, some)
            found.update({f"{frames.name}:{k}": result[k] for k in ("auc", "iou_dynamic")})
    return found


def third(cache: Path, number: int) -> list[Frames]:
    """The frames with motion labels of one third of the drives."""
    found = []
    for source in streets.MOTION:
        frames = streets.load(f"labeled_{source}", cache)
        found.append(frames.of(np.flatnonzero(np.isin(frames.drives, streets.THIRDS[number]))))
    return [f for f in found if len(f)]


def by_preset(predict: Predict, cache: Path) -> dict[str, dict[str, float]]:
    """States in the rendered courses that traffic fills, each by itself, where they are in the cache."""
    if not (cache / "streets_traffic_dev.npz").is_file():
        return {}
    frames = streets.load("traffic_dev", cache)
    return {name: states(predict, [frames.of(np.flatnonzero(frames.drives == name))]) for name in np.unique(frames.drives)}


def evaluate(predict: Predict, cache: Path, left_out: int | None) -> dict[str, dict[str, float]]:
    """Classes on the validation sets and states on `dev`; or states on the third of the drives that was left out."""
    if left_out is None:
        found = {name: classes(predict, streets.load(name, cache)) for name in CLASSES}
        found["dev"] = states(predict, [streets.load("dev", cache)])
        return found | by_preset(predict, cache)
    sets = third(cache, left_out)
    found = {f"third_{left_out}": states(predict, sets)}
    for frames in sets:
        for drive in np.unique(frames.drives):
            found[f"  {drive}"] = states(predict, [frames.of(np.flatnonzero(frames.drives == drive))])
    return found
