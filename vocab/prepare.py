#!/usr/bin/env python3
"""Decodes the training images (WebP) to PNG, as the training reads them. Needs Pillow.

Usage: prepare.py TRAINING OUT, TRAINING being the folder with cityscapes256, idd_lite, camvid and kitti_pseudo. Only the
training splits are taken. The Cityscapes frames are stretched back to their 2:1 shape.
"""

import sys
from pathlib import Path

from PIL import Image

FOLDERS = ["cityscapes256/train", "idd_lite/train", "camvid/train", "kitti_pseudo/*"]


def main(training: Path, out: Path) -> None:
    images = [p for f in FOLDERS for p in sorted(training.glob(f"{f}/image/*.webp"))]
    for path in images:
        target = out / path.relative_to(training).with_suffix(".png")
        target.parent.mkdir(parents=True, exist_ok=True)
        image = Image.open(path).convert("RGB")
        if path.relative_to(training).parts[0] == "cityscapes256":
            image = image.resize((2 * image.width, image.height), Image.Resampling.BILINEAR)
        image.save(target, compress_level=1)
    print(f"{len(images)} images")


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(Path(sys.argv[1]), Path(sys.argv[2]))
