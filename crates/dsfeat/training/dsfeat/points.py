"""Judges what the program believes of tracked points (table of the example `belief`), on `kittiraw_0005` or a rendered town.

    cargo run --release -p dsslam-tests --example belief -- SEQUENCE all features.selection=activation features.keep=2000 > points.csv
    python -m dsfeat.points --table points.csv [--masks SEQUENCE/masks]

AUC of standing against moving and of static against moving points, by the network's word on the feature alone, by the belief in the
point with this frame, and by the weight that RANSAC makes of both, for points seen in at least 1, 2, 3, 5 and 10 frames. With `all` features are
kept by response: selection by activation leaves next to no moving points to judge.

A point of a rendered town is what its pixel's label says where that label lies all about. One of `kittiraw_0005` is what the 3-D box
says in which the frame's own disparity puts the feature. Most earlier sights of the point must agree: a point of the wall that is matched
once with a corner of a car is not a moving point.
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
#: A feature within this many meters of a box's side, and so many pixels of disparity, may belong to either side.
EDGE, DISPARITY_ERROR = 0.3, 0.5
#: Rows are judged whose point has been matched in at least so many frames, this one included.
SIGHTINGS = (1, 2, 3, 5, 10)
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


def in_boxes(table: np.ndarray, path: Path, camera: tuple[float, float, float, float]) -> np.ndarray:
    """The label of each row by the 3-D boxes of `kittiraw_0005`: where the frame's own disparity puts the feature, which does not ask
    whether its point stands. 0 near a box's side, without disparity, and in the image regions that nobody has boxes for.

    `camera`: focal length and middle column and row, px, base line, m. The boxes are in meters, of the left camera: x, y of the
    floor's middle, z; turned by an angle about the vertical axis.
    """
    focal, middle_x, middle_y, base = camera
    depth = focal * base / np.maximum(focal * base / table["Z"] + table["du"] - table["dr"], 1.0)
    place = np.stack([(table["x"] - middle_x) / focal * depth, (table["y"] - middle_y) / focal * depth, depth])
    found = np.where(np.isnan(depth), 0, LABEL_STATIC).astype(np.uint8)
    unsure = EDGE + DISPARITY_ERROR * np.nan_to_num(depth) ** 2 / (focal * base)
    for row in path.read_text().splitlines():
        words = row.split()
        here = table["frame"] == int(words[0])
        left, top, right, bottom, high, wide, long, *middle, turn = map(float, words[6:17])
        if words[2] == "DontCare":
            found[here & (table["x"] > left) & (table["x"] < right) & (table["y"] > top) & (table["y"] < bottom)] = 0
            continue
        x, y, z = place - np.array(middle)[:, None]
        along, across = np.cos(turn) * x - np.sin(turn) * z, np.sin(turn) * x + np.cos(turn) * z
        off = np.maximum(np.maximum(np.abs(along) - long / 2, np.abs(across) - wide / 2), np.maximum(y + unsure, -high - y))
        found[here & (off < 2 * unsure)] = 0
        found[here & (off < 0)] = LABEL_MOVING if int(words[1]) in MOVERS else LABEL_STANDING
    return found


def camera_of(path: Path) -> tuple[float, float, float, float]:
    """Focal length, middle column and row, px, and base line, m, of a KITTI `calib.txt`."""
    left, right = (np.array(row.split()[1:], float).reshape(3, 4) for row in path.read_text().splitlines() if row[:3] in ("P0:", "P1:"))
    return left[0, 0], left[0, 2], left[1, 2], -right[0, 3] / right[0, 0]


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
    else:
        need(parser, args, "sequences")
        folder = args.sequences / "kittiraw_0005"
        labels = in_boxes(table, folder / "label_02_tracking0000.txt", camera_of(folder / "calib.txt"))
    on_mover = np.where(labels == 0, np.nan, labels == LABEL_MOVING)
    labels = agreeing(table, labels, on_mover)
    # Log-odds are told apart where probabilities near 1 are not.
    odds = np.log(np.clip(table["belief"], 1e-4, 1 - 1e-4) / np.clip(1 - table["belief"], 1e-4, 1 - 1e-4))
    values = {"word": table["word"], "belief": (odds + 10) / 20, "weight": table["word"] * np.minimum(2 * table["belief"], 1)}
    for least in SIGHTINGS:
        chosen = (table["sights"] + 1 >= least) & (labels > 0)
        counts = [int((labels[chosen] == c).sum()) for c in (LABEL_STATIC, LABEL_STANDING, LABEL_MOVING)]
        points = len(np.unique(table["point"][chosen & (labels == LABEL_MOVING)]))
        print(f"after {least} sightings or more: static, standing, moving {counts}, moving ones of {points} points")
        for name, value in values.items():
            standing, static = (auc(value[chosen], labels[chosen], c) for c in (LABEL_STANDING, LABEL_STATIC))
            print(f"  {name:6}: standing/moving {standing:.3f}, static/moving {static:.3f}")


if __name__ == "__main__":
    main()
