"""Judges what the map believes of tracked points by the motion labels of `dev` (table of the example `belief`).

    cargo run --release -p dsslam-tests --example belief -- kittiraw_0005 > points.csv
    python -m dsfeat.points --table points.csv

AUC of standing against moving and of static against moving points, by the network's word on the feature alone and by the belief in
the point before the frame, for points that were matched in at least so many earlier frames.
"""

import argparse
from pathlib import Path

import numpy as np

from .data import add_folders, need, read_classes
from .metrics import Tally
from .streets import LABEL_MOVING, LABEL_STANDING, LABEL_STATIC


def labels_of(table: np.ndarray, folder: Path) -> np.ndarray:
    """The label at each row's pixel; 0 where there is none. Labels have half the images' size."""
    found = np.zeros(len(table), np.uint8)
    for path in sorted(folder.glob("*.webp")):
        label, rows = read_classes(path), np.flatnonzero(table["frame"] == int(path.stem.split("_")[1]))
        x, y = (np.clip((table[k][rows] + 0.5) / 2, 0, n - 1).astype(int) for k, n in (("x", label.shape[1]), ("y", label.shape[0])))
        found[rows] = label[y, x]
    return found


def auc(values: np.ndarray, labels: np.ndarray, high: int) -> float:
    """AUC of the class `high` against moving points."""
    tally = Tally()
    tally.add(values.astype(np.float32), labels == high, labels == LABEL_MOVING)
    return tally.auc()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--table", type=Path, required=True, help="what the example `belief` prints of kittiraw_0005")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "training")
    table = np.genfromtxt(args.table, delimiter=",", names=True)
    labels = labels_of(table, args.training / "motion" / "dev" / "kittiraw_0005" / "label")
    for least in (0, 1, 2, 5, 10):
        chosen = (table["sights"] >= least) & (labels > 0)
        part, known = table[chosen], labels[chosen]
        counts = [int((known == c).sum()) for c in (LABEL_STATIC, LABEL_STANDING, LABEL_MOVING)]
        for name in ("word", "belief"):
            standing, static = (auc(part[name], known, c) for c in (LABEL_STANDING, LABEL_STATIC))
            print(f"{least:2} sights, {name:6}: standing/moving {standing:.3f}, static/moving {static:.3f} (static, standing, moving: {counts})")


if __name__ == "__main__":
    main()
