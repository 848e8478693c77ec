"""Stability maps of photographs by the vote of three teachers (Cityscapes and VOC segmenters of free licences).

    python -m dsfeat.teachers --images FOLDER --teachers TEACHERS --out LABELS

Where at least two of the three see a vehicle, a person or a bicycle the pixel is dynamic (255), where one does it is not
decided (128), else it is static (0): the format of `kitti_pseudo`. Finished frames are skipped.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np

from .data import DYNAMIC_CLASSES, spread
from .runtime import session

#: Files of the teachers: two tiled networks (TensorFlow Lite) with their dynamic classes, and a whole-frame one (ONNX).
TILED = {
    "voc_deeplabv3_mobilenetv2_int8.tflite": (2, 6, 7, 14, 15),
    "cityscapes_deeplab_edgetpu_slim_int8.tflite": DYNAMIC_CLASSES["cityscapes256"],
}
WHOLE = "cityscapes_espnetv2_1248x384.onnx"
#: Width of a tile in heights of the frame, and the width that a tile adds at least.
TILE, ADDS = 1.2, 0.8
MEAN, DEVIATION = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])
#: Values of the maps.
STATIC, UNDECIDED, DYNAMIC = 0, 128, 255


def tiles(width: int, height: int) -> list[tuple[int, int]]:
    """First and last-plus-one column of overlapping tiles that cover the frame: four for KITTI's aspect."""
    wide = min(width, round(TILE * height))
    count = max(1, int(np.ceil((width / height - (TILE - ADDS)) / ADDS)))
    return [(x, x + wide) for x in np.linspace(0, width - wide, count).round().astype(int)]


class Tiled:
    """A TensorFlow Lite segmenter that sees the frame in tiles: bool [H, W] of dynamic pixels."""

    def __init__(self, path: Path, classes: tuple[int, ...]):
        from ai_edge_litert.interpreter import Interpreter

        self.model = Interpreter(str(path), num_threads=1)
        self.model.allocate_tensors()
        self.given, self.found = self.model.get_input_details()[0], self.model.get_output_details()[0]
        self.classes = classes

    def __call__(self, image: np.ndarray) -> np.ndarray:
        height, width = image.shape[:2]
        side = tuple(int(n) for n in self.given["shape"][2:0:-1])
        out = np.zeros((height, width), bool)
        nearest = np.full(width, np.inf)
        for first, last in tiles(width, height):
            shown = cv2.resize(image[:, first:last], side, interpolation=cv2.INTER_LINEAR)
            self.model.set_tensor(self.given["index"], shown[None])
            self.model.invoke()
            dynamic = np.isin(self.model.get_tensor(self.found["index"])[0], self.classes).astype(np.uint8)
            dynamic = cv2.resize(dynamic, (last - first, height), interpolation=cv2.INTER_NEAREST) > 0
            # Where tiles overlap, the one whose middle is nearer speaks.
            distance = np.abs(np.arange(first, last) - 0.5 * (first + last - 1))
            wins = distance < nearest[first:last]
            out[:, first:last][:, wins] = dynamic[:, wins]
            nearest[first:last][wins] = distance[wins]
        return out


class Whole:
    """An ONNX segmenter that sees the whole frame; a frame that is less wide than its input is continued as in a mirror."""

    def __init__(self, path: Path):
        self.model = session(path)
        self.given = self.model.get_inputs()[0]

    def __call__(self, image: np.ndarray) -> np.ndarray:
        rows, columns = self.given.shape[2:]
        height, width = image.shape[:2]
        used = columns if width / height > 0.8 * columns / rows else round(rows * width / height)
        shown = cv2.resize(image, (used, rows), interpolation=cv2.INTER_LINEAR)
        shown = cv2.copyMakeBorder(shown, 0, 0, 0, columns - used, cv2.BORDER_REFLECT)
        shown = ((shown / 255.0 - MEAN) / DEVIATION).astype(np.float32).transpose(2, 0, 1)[None]
        classes = self.model.run(None, {self.given.name: shown})[0][0].argmax(axis=0)[:, :used]
        dynamic = np.isin(classes, DYNAMIC_CLASSES["cityscapes256"]).astype(np.uint8)
        return cv2.resize(dynamic, (width, height), interpolation=cv2.INTER_NEAREST) > 0


class Vote:
    """The vote of all teachers of a folder: uint8 [H, W] of STATIC, UNDECIDED and DYNAMIC."""

    def __init__(self, folder: Path):
        self.teachers = [Tiled(folder / name, classes) for name, classes in TILED.items()] + [Whole(folder / WHOLE)]

    def __call__(self, image: np.ndarray) -> np.ndarray:
        votes = sum(teacher(image).astype(np.uint8) for teacher in self.teachers)
        return np.array([STATIC, UNDECIDED, DYNAMIC, DYNAMIC], np.uint8)[votes]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--images", type=Path, required=True, nargs="+", help="folders of images")
    parser.add_argument("--teachers", type=Path, required=True, help="folder of the three segmenters")
    parser.add_argument("--out", type=Path, required=True, nargs="+", help="folders of maps, one for each of --images")
    parser.add_argument("--most", type=int, help="use at most this many images of a folder, evenly spread")
    args = parser.parse_args()
    if len(args.images) != len(args.out):
        parser.error("--images and --out need as many folders")
    cv2.setNumThreads(1)
    vote = Vote(args.teachers)
    for folder, out in zip(args.images, args.out):
        out.mkdir(parents=True, exist_ok=True)
        for path in spread(sorted(p for p in folder.iterdir() if p.suffix in (".png", ".jpg", ".webp")), args.most):
            if not (out / f"{path.stem}.png").is_file():
                image = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
                cv2.imwrite(str(out / f"{path.stem}.png"), vote(image))
        print(f"{out}: {len(list(out.glob('*.png')))} maps", flush=True)


if __name__ == "__main__":
    main()
