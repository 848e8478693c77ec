"""Judges what the map believes of tracked points (table of the example `belief`), on `kittiraw_0005` or a rendered town.

    cargo run --release -p dsslam-tests --example belief -- SEQUENCE features.selection=activation features.keep=2000 > points.csv
    python -m dsfeat.points --table points.csv [--masks SEQUENCE/masks]

AUC of standing against moving and of static against moving points, by the network's word on the feature alone, by the belief in the
point before the frame, and by the weight that RANSAC makes of both, for points that the map has judged by at least 0, 1, 2, 5 and 10 frames.

A point is what its pixel's label says where that label lies all about (outlines are a few pixels off) and most earlier sights of the point
agree: a point of the wall that is matched once with a corner of a car is not a moving point. On `kittiraw_0005`, where every fourth frame has
labels, the boxes of what moves tell for the other frames.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

from .data import add_folders, need, read_classes
from .metrics import Tally
from .streets import LABEL_MOVING, LABEL_STANDING, LABEL_STATIC

#: A label counts where it fills this many pixels about the point.
ABOUT = 3
#: Share of a point's earlier sights that must have been on what moves (and for the others at most the rest).
AGREED = 0.8
#: What moves in `kittiraw_0005`: tracks of its boxes whose pixels the motion labels call moving.
MOVERS = (0, 1, 2, 4, 12)
#: Labels of the masks of rendered towns.
MASKS = np.array([LABEL_STATIC, LABEL_MOVING, LABEL_STANDING, LABEL_STATIC], np.uint8)


def labels_of(table: np.ndarray, maps: dict[int, np.ndarray], scale: float) -> np.ndarray:
    """The label at each row's pixel; 0 where there is none or another one close by. `scale`: image pixels of a label's pixel."""
    found = np.zeros(len(table), np.uint8)
    about = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * ABOUT + 1, 2 * ABOUT + 1))
    for frame, label in maps.items():
        rows = np.flatnonzero(table["frame"] == frame)
        sure = sum(value * cv2.erode((label == value).astype(np.uint8), about) for value in (LABEL_STATIC, LABEL_STANDING, LABEL_MOVING))
        x, y = (np.clip((table[k][rows] + 0.5) / scale, 0, n - 1).astype(int) for k, n in (("x", label.shape[1]), ("y", label.shape[0])))
        found[rows] = sure[y, x]
    return found


def on_boxes(table: np.ndarray, path: Path) -> np.ndarray:
    """Whether each row's pixel lies in a box of what moves (1, 0)."""
    found = np.zeros(len(table))
    for row in path.read_text().splitlines():
        words = row.split()
        if int(words[1]) in MOVERS:
            left, top, right, bottom = map(float, words[6:10])
            here = (table["frame"] == int(words[0])) & (table["x"] > left) & (table["x"] < right)
            found[here & (table["y"] > top) & (table["y"] < bottom)] = 1.0
    return found


def agreeing(table: np.ndarray, labels: np.ndarray, on_mover: np.ndarray) -> np.ndarray:
    """Labels without those that the point's earlier sights contradict; `on_mover` is 1, 0 or NaN (not known) for each row."""
    out, earlier = labels.copy(), {}
    for i in np.lexsort((table["frame"],)):
        moved, seen = earlier.get(table["point"][i], (0.0, 0))
        share = moved / seen if seen else 0.5
        if seen and (share < AGREED if labels[i] == LABEL_MOVING else share > 1 - AGREED):
            out[i] = 0
        if not np.isnan(on_mover[i]):
            earlier[table["point"][i]] = (moved + on_mover[i], seen + 1)
    return out


def auc(values: np.ndarray, labels: np.ndarray, high: int) -> float:
    """AUC of the class `high` against moving points, by values in 0..1."""
    tally = Tally()
    tally.add(values.astype(np.float32), labels == high, labels == LABEL_MOVING)
    return tally.auc()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--table", type=Path, required=True, help="what the example `belief` prints")
    parser.add_argument("--masks", type=Path, help="the table is of a rendered town with these masks, not of kittiraw_0005")
    add_folders(parser)
    args = parser.parse_args()
    table = np.genfromtxt(args.table, delimiter=",", names=True)
    if args.masks:
        labels = labels_of(table, {int(p.stem): MASKS[read_classes(p)] for p in sorted(args.masks.glob("*.png"))}, 1.0)
        on_mover = np.where(labels == 0, np.nan, labels == LABEL_MOVING)
    else:
        need(parser, args, "training", "sequences")
        folder = args.training / "motion" / "dev" / "kittiraw_0005" / "label"
        labels = labels_of(table, {int(p.stem.split("_")[1]): read_classes(p) for p in sorted(folder.glob("*.webp"))}, 2.0)
        on_mover = on_boxes(table, args.sequences / "kittiraw_0005" / "label_02_tracking0000.txt")
    labels = agreeing(table, labels, on_mover)
    # Log-odds are told apart where probabilities near 1 are not.
    odds = np.log(np.clip(table["belief"], 1e-4, 1 - 1e-4) / np.clip(1 - table["belief"], 1e-4, 1 - 1e-4))
    values = {"word": table["word"], "belief": (odds + 10) / 20, "weight": table["word"] * np.minimum(2 * table["belief"], 1)}
    for least in (0, 1, 2, 5, 10):
        chosen = (table["judged"] >= least) & (labels > 0)
        counts = [int((labels[chosen] == c).sum()) for c in (LABEL_STATIC, LABEL_STANDING, LABEL_MOVING)]
        print(f"judged by {least} frames: static, standing, moving {counts}")
        for name, value in values.items():
            standing, static = (auc(value[chosen], labels[chosen], c) for c in (LABEL_STANDING, LABEL_STATIC))
            print(f"  {name:6}: standing/moving {standing:.3f}, static/moving {static:.3f}")


if __name__ == "__main__":
    main()
