"""Readers of the labelled road scenes: grey images with stability maps (1 static, 0 dynamic, 2 ignored).

`build` decodes a data set once into `<cache>/<name>.npz`; `load` gives it back as arrays. Names of the sets:
`cityscapes_train`, `cityscapes_val`, `idd_train`, `idd_val`, `camvid_train`, `camvid_val`, `camvid_test`,
`kitti_train` and `kitti_val` (pseudo-labels) and `town_<preset>_<seed>` (rendered).

    python -m dsfeat.data --training TRAINING --sequences DATA --towns TOWNS --cache CACHE
"""

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

#: Values of a stability map.
DYNAMIC, STATIC, IGNORED = 0, 1, 2
#: Values of the masks of rendered towns.
TOWN_STILL, TOWN_MOVING, TOWN_PARKED, TOWN_SKY = 0, 1, 2, 3
#: Dynamic classes and ignored classes of each source of labels.
DYNAMIC_CLASSES = {
    "cityscapes256": (11, 12, 13, 14, 15, 16, 17, 18),
    "idd_lite": (2, 3),
    "camvid": (8, 9, 10),
    "kitti_pseudo": (255,),
    "town": (TOWN_MOVING, TOWN_PARKED),
}
IGNORED_CLASSES = {"cityscapes256": (255,), "idd_lite": (255,), "camvid": (11,), "kitti_pseudo": (128,), "town": ()}
#: Pseudo-labelled sequences to train on; they are in no evaluation of the SLAM system.
KITTI_TRAIN = ("kittiraw_0926_0009", "sfnd_kitti_mono78_rgb", "kitti_alike")
#: Pseudo-labelled sequences on which the SLAM system is evaluated: never trained on.
KITTI_VAL = ("kitti03_first400", "kittiraw_0005", "kittiraw_1405", "kitti06_first51")
#: Every n-th frame of a rendered town gets into the semantic stage.
TOWN_STEP = 3


@dataclass
class Scenes:
    """Images [N, H, W] uint8, maps [N, H, W] uint8 (0, 1, 2), `aspect` = true width / height of each frame.

    `labels` are the source's own classes, [N, H, W] uint8.
    """

    name: str
    images: np.ndarray
    maps: np.ndarray
    labels: np.ndarray
    aspect: float

    def __len__(self) -> int:
        return len(self.images)


def stability(labels: np.ndarray, source: str) -> np.ndarray:
    """Stability map of a class map: the paper's S, class-based (parked vehicles count as dynamic)."""
    table = np.full(256, STATIC, np.uint8)
    table[list(DYNAMIC_CLASSES[source])] = DYNAMIC
    table[list(IGNORED_CLASSES[source])] = IGNORED
    return table[labels]


def read_grey(path: Path) -> np.ndarray:
    """Image as grey uint8 [H, W]."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise SystemExit(f"{path}: not an image that can be read")
    return image


def read_classes(path: Path) -> np.ndarray:
    """Class map uint8 [H, W]: the first channel, untouched."""
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise SystemExit(f"{path}: not a label image that can be read")
    return image if image.ndim == 2 else np.ascontiguousarray(image[..., 0])


def resize_pair(image: np.ndarray, labels: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Image by area, labels by nearest neighbour, to `size` = (width, height)."""
    if (image.shape[1], image.shape[0]) != size:
        image = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
    if (labels.shape[1], labels.shape[0]) != size:
        labels = cv2.resize(labels, size, interpolation=cv2.INTER_NEAREST)
    return image, labels


def collect(name: str, source: str, pairs: list[tuple[Path, Path]], size: tuple[int, int], aspect: float) -> Scenes:
    """Decodes (image, label) files to `size`."""
    if not pairs:
        raise SystemExit(f"{name}: no labelled images found")
    read = [resize_pair(read_grey(i), read_classes(m), size) for i, m in pairs]
    images, labels = (np.stack(x) for x in zip(*read))
    return Scenes(name, images, stability(labels, source), labels, aspect)


def spread(paths: list[Path], most: int | None) -> list[Path]:
    """At most `most` of the paths, evenly spread; all of them without a limit."""
    if most is None or most >= len(paths):
        return paths
    return [paths[i] for i in np.linspace(0, len(paths) - 1, most).round().astype(int)]


def pairs_of(folder: Path) -> list[tuple[Path, Path]]:
    """Labelled images of a folder with `image/` and `label/`, by name."""
    return [(folder / "image" / p.name, p) for p in sorted((folder / "label").glob("*.webp"))]


def kitti_pairs(training: Path, sequences: Path, names: tuple[str, ...]) -> list[tuple[Path, Path]]:
    """Pseudo-labelled frames; those without images of their own are looked up in the unpacked sequences."""
    pairs = []
    for name in names:
        folder = training / "kitti_pseudo" / name
        if (folder / "image").is_dir():
            pairs += pairs_of(folder)
        else:
            labels = sorted((folder / "label").glob("*.webp"))
            pairs += [(sequences / name / "image_0" / f"{p.stem}.png", p) for p in labels]
    return pairs


def town_pairs(folder: Path, step: int) -> list[tuple[Path, Path]]:
    """Every `step`-th frame of a rendered town with its mask."""
    return [(folder / "image_0" / p.name, p) for p in sorted((folder / "masks").glob("*.png"))[::step]]


def read_set(name: str, training: Path, sequences: Path, towns: Path) -> Scenes:
    """Decodes one data set by its name."""
    kind, _, part = name.partition("_")
    if kind == "cityscapes":
        return collect(name, "cityscapes256", pairs_of(training / "cityscapes256" / part), (256, 256), 2.0)
    if kind == "idd":
        return collect(name, "idd_lite", pairs_of(training / "idd_lite" / part), (320, 227), 320 / 227)
    if kind == "camvid":
        return collect(name, "camvid", pairs_of(training / "camvid" / part), (480, 360), 4 / 3)
    if kind == "kitti":
        names = KITTI_TRAIN if part == "train" else KITTI_VAL
        return collect(name, "kitti_pseudo", kitti_pairs(training, sequences, names), (620, 187), 1242 / 375)
    if kind == "town":
        return collect(name, "town", town_pairs(towns / part, TOWN_STEP), (620, 188), 1241 / 376)
    raise SystemExit(f"{name}: unknown data set")


def load(name: str, cache: Path) -> Scenes:
    """A data set from the cache."""
    path = cache / f"{name}.npz"
    if not path.is_file():
        raise SystemExit(f"{path}: not there; run `python -m dsfeat.data` first")
    with np.load(path) as file:
        return Scenes(name, file["images"], file["maps"], file["labels"], float(file["aspect"]))


def build(name: str, cache: Path, training: Path, sequences: Path, towns: Path) -> None:
    """Decodes a data set into the cache unless it is there."""
    path = cache / f"{name}.npz"
    if path.is_file():
        return
    scenes = read_set(name, training, sequences, towns)
    part = path.with_suffix(".part.npz")
    np.savez(part, images=scenes.images, maps=scenes.maps, labels=scenes.labels, aspect=scenes.aspect)
    os.replace(part, path)
    share = float((scenes.maps == DYNAMIC).mean())
    print(f"{name}: {len(scenes)} images of {scenes.images.shape[2]}x{scenes.images.shape[1]}, {share:.1%} dynamic", flush=True)


ROAD_SETS = (
    "cityscapes_train", "cityscapes_val", "idd_train", "idd_val", "camvid_train", "camvid_val", "camvid_test",
    "kitti_train", "kitti_val",
)


def add_folders(parser: argparse.ArgumentParser) -> None:
    """The folders that all programs take, by argument or environment."""
    environment = os.environ.get
    parser.add_argument("--training", type=Path, default=environment("DSFEAT_TRAINING"), help="labelled road scenes")
    parser.add_argument("--sequences", type=Path, default=environment("DSSLAM_DATA"), help="unpacked sequences")
    parser.add_argument("--towns", type=Path, default=environment("DSFEAT_TOWNS"), help="rendered towns")
    parser.add_argument("--cache", type=Path, default=environment("DSFEAT_CACHE"), help="folder of decoded data")


def need(parser: argparse.ArgumentParser, args: argparse.Namespace, *names: str) -> None:
    """Ends with a message where a folder was not given."""
    for name in names:
        if getattr(args, name) is None:
            parser.error(f"--{name} (or its environment variable) is needed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_folders(parser)
    parser.add_argument("--sets", nargs="*", help="data sets; by default all road scenes and all towns found")
    args = parser.parse_args()
    need(parser, args, "training", "sequences", "towns", "cache")
    args.cache.mkdir(parents=True, exist_ok=True)
    found = sorted(f"town_{p.name}" for p in args.towns.iterdir() if (p / "poses.txt").is_file())
    for name in args.sets or [*ROAD_SETS, *found]:
        build(name, args.cache, args.training, args.sequences, args.towns)


if __name__ == "__main__":
    main()
