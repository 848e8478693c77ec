"""Prepares matching and semantic information for training.

    python -m dsfeat.prepare loops --sequence TOWN/image_0 --step 5 --xfeat xfeat.onnx --out triplets_town.csv
    python -m dsfeat.prepare triplets --csv A.csv:ROOT:LIMIT B.csv:ROOT:LIMIT --xfeat xfeat.onnx --cache CACHE
    python -m dsfeat.prepare motion --sequence TOWN:STEP ... --cache CACHE
    python -m dsfeat.prepare semantic --images FOLDER --segmenter espnetv2.onnx --out LABELS

`loops` finds loops by place recognition and writes (query, positive, negative); `triplets` computes descriptors and
matches of such lists; `motion` labels moving points of stereo sequences; `vehicles` the
same on vehicles of real sequences, for evaluation only; `semantic` writes stability maps (0 static,
255 dynamic, 128 unsure) with a Cityscapes segmenter, for the reader `kitti_pseudo`.
"""

import argparse
import csv
from pathlib import Path

import cv2
import numpy as np

from .augment import whole
from .data import DYNAMIC, DYNAMIC_CLASSES, add_folders, need, read_classes, read_grey, resize_pair, stability
from .runtime import session
from .matching import Features, features, packed, pair, to_unit
from .motion import UNKNOWN, exact, label_frame, read_rig, refined
from .network import HEIGHT, WIDTH
from .places import bags, features_of, find_loops, find_negative, similarities, vocabulary
from .triplets import MOTION, TRIPLETS, VEHICLES

#: Labelled points kept per frame.
POINTS = 640
#: Size (width, height) at which frames with motion labels are kept.
STORED = (620, 188)
#: Frames after which (before which) motion is judged: distant vehicles need long, near ones soon leave the view.
SPANS = (-3, 3, 8)
#: The same to evaluate on real vehicles.
SPAN = 4
#: Frames closer than this (times step) are the same visit.
GAP_FRAMES = 200


class Dense:
    """XFeat's dense descriptors of a whole frame at the network's size: [12, 40, 64] float16, unit length."""

    def __init__(self, path: Path):
        self.session = session(path)
        self.name = self.session.get_inputs()[0].name

    def __call__(self, image: np.ndarray) -> np.ndarray:
        shown = np.repeat(whole(image)[None, None], 3, axis=1)
        outputs = self.session.run(None, {self.name: shown})
        found = next(o for o in outputs if o.shape[1] == 64)[0].transpose(1, 2, 0)
        return (found / np.maximum(np.linalg.norm(found, axis=-1, keepdims=True), 1e-9)).astype(np.float16)


def small(image: np.ndarray) -> np.ndarray:
    """The whole frame at the network's size, uint8."""
    return np.rint(255.0 * whole(image)).astype(np.uint8)


def loops(args: argparse.Namespace) -> None:
    """Finds loops in one sequence and writes triplets."""
    paths = sorted(args.sequence.glob("*.png"))[:: args.step]
    images = [read_grey(p) for p in paths]
    dense = Dense(args.xfeat)
    descriptors = np.stack([dense(image).reshape(-1, 64) for image in images])
    words = vocabulary(descriptors[:: max(1, len(images) // 60)].reshape(-1, 64))
    scores = similarities(bags(descriptors, words))
    found = features_of(images)
    gap = max(3, GAP_FRAMES // args.step)
    rng = np.random.default_rng(1)
    rows = []
    for loop in find_loops(scores, found, gap):
        negative = find_negative(scores, found, loop, gap, rng)
        if negative:
            named = [str(paths[i].relative_to(args.root)) for i in (loop.query, loop.match, negative[0])]
            rows.append([*named, loop.inliers, negative[1]])
    with args.out.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["query", "positive", "negative", "pos_inliers", "neg_inliers"])
        writer.writerows(rows)
    print(f"{args.out}: {len(rows)} triplets of {len(paths)} frames")


def read_list(entry: str) -> tuple[list[list[Path]], str]:
    """`file.csv:root:limit` -> at most `limit` evenly spread triplets of paths, and the list's name."""
    name, root, limit = entry.rsplit(":", 2)
    with open(name, newline="") as file:
        rows = [[Path(root) / row[k] for k in ("query", "positive", "negative")] for row in csv.DictReader(file)]
    keep = np.linspace(0, len(rows) - 1, min(int(limit), len(rows))).round().astype(int)
    return [rows[i] for i in keep], Path(name).stem


def triplets(args: argparse.Namespace) -> None:
    """Descriptors and matches of all listed triplets into `triplets.npz`."""
    dense = Dense(args.xfeat)
    number: dict[Path, int] = {}
    found: list[Features] = []
    arrays: dict[str, list] = {k: [] for k in ("images", "descriptors", "index", "points", "errors", "source")}

    def frame(path: Path) -> int:
        if path not in number:
            image = read_grey(path)
            number[path] = len(found)
            found.append(features(image))
            arrays["images"].append(small(image))
            arrays["descriptors"].append(dense(image))
        return number[path]

    for source, entry in enumerate(args.csv):
        rows, name = read_list(entry)
        for row in rows:
            q, p, n = (frame(path) for path in row)
            packs = [packed(pair(found[q], found[k]), found[q].size, found[k].size) for k in (p, n)]
            arrays["index"].append([q, p, n])
            arrays["points"].append(np.stack([x[0] for x in packs]))
            arrays["errors"].append(np.stack([x[1] for x in packs]))
            arrays["source"].append(source)
        print(f"{name}: {len(rows)} triplets", flush=True)
    np.savez(args.cache / TRIPLETS, **{k: np.array(v) for k, v in arrays.items()})


def observed(folder: Path, lefts: list[Path], t: int, spans: tuple[int, ...], kinds: np.ndarray | None = None):
    """Labelled points of frame `t` of a stereo sequence judged after each of `spans` frames, or None (see `label_frame`).

    Negative spans are earlier frames: what is near us and comes towards us has left the view when the next frame is taken.
    """
    rig = read_rig((folder / "calib.txt").read_text())
    found = []
    for sign in (-1, 1):
        steps = [abs(k) for k in spans if k * sign > 0 and 0 <= t + k < len(lefts)]
        if steps:
            window = [read_grey(lefts[t + sign * k]) for k in range(max(steps) + 1)]
            rights = {k: read_grey(folder / "image_1" / lefts[t + sign * k].name) for k in (0, *steps)}
            found.append(label_frame(rig, window, rights, kinds))
    found = [f for f in found if f is not None]
    return tuple(np.concatenate(x) for x in zip(*found)) if found else None


def motion(args: argparse.Namespace) -> None:
    """Stability maps refined by motion of every STEP-th frame of rendered towns into `motion.npz`, but for the last frames of each.

    Which vehicles move says the renderer's mask, or the residuals of `dsfeat.motion` (then only the class is read of the mask).
    Raises SystemExit where no sequence has frames enough.
    """
    images, maps, source = [], [], []
    for number, entry in enumerate(args.sequence):
        name, step = entry.rsplit(":", 1)
        folder = Path(name)
        lefts = sorted((folder / "image_0").glob("*.png"))
        count = 0
        for t in range(0, len(lefts) - max(SPANS), int(step)):
            mask = read_classes(folder / "masks" / lefts[t].name)
            if args.labels == "masks":
                found = exact(mask)
            else:
                kinds = stability(mask, "town")
                result = observed(folder, lefts, t, SPANS, kinds)
                if result is None:
                    continue
                found = refined(kinds, *result)
            image, labels = resize_pair(read_grey(lefts[t]), found, STORED)
            images.append(image)
            maps.append(labels)
            source.append(number)
            count += 1
        print(f"{name}: {count} frames", flush=True)
    if not images:
        raise SystemExit(f"motion: no frame can be labeled; a sequence needs more than {max(SPANS)} frames")
    np.savez(args.cache / MOTION, images=np.array(images), maps=np.array(maps), source=np.array(source))


def vehicles(args: argparse.Namespace) -> None:
    """Motion labels of the points on dynamic classes in pseudo-labelled stereo sequences, into `vehicles.npz`: for evaluation."""
    images, points, labels, source = [], [], [], []
    for number, name in enumerate(args.names):
        folder = args.sequences / name
        lefts = sorted((folder / "image_0").glob("*.png"))
        index = {p.stem: i for i, p in enumerate(lefts)}
        for path in sorted((args.training / "kitti_pseudo" / name / "label").glob("*.webp"))[:: args.step]:
            t = index[path.stem]
            if t + SPAN >= len(lefts):
                continue
            result = observed(folder, lefts, t, (SPAN,))
            if result is None:
                continue
            kinds = stability(read_classes(path), "kitti_pseudo")
            place, label = result
            column, row = np.rint(place).astype(int).T
            kept = np.flatnonzero((kinds[row.clip(0, kinds.shape[0] - 1), column.clip(0, kinds.shape[1] - 1)] == DYNAMIC) & (label != UNKNOWN))
            one, state = np.zeros((POINTS, 2), np.float32), np.full(POINTS, UNKNOWN, np.uint8)
            kept = kept[:POINTS]
            one[: len(kept)] = to_unit(place[kept], kinds.shape[::-1])
            state[: len(kept)] = label[kept]
            images.append(small(read_grey(lefts[t])))
            points.append(one)
            labels.append(state)
            source.append(number)
        ours = np.array([x for x, s in zip(labels, source) if s == number])
        print(f"{name}: {len(ours)} frames, {(ours == 0).sum()} moving and {(ours == 1).sum()} standing points on vehicles", flush=True)
    arrays = {"images": images, "points": points, "labels": labels, "source": source, "names": args.names}
    np.savez(args.cache / VEHICLES, **{k: np.array(v) for k, v in arrays.items()})


def semantic(args: argparse.Namespace) -> None:
    """Stability maps of all images of a folder by a segmenter: 0 static, 255 dynamic, 128 unsure."""
    model = session(args.segmenter)
    given = model.get_inputs()[0]
    height, width = given.shape[2:]
    mean, deviation = np.array([0.485, 0.456, 0.406]), np.array([0.229, 0.224, 0.225])
    args.out.mkdir(parents=True, exist_ok=True)
    for path in sorted(p for p in args.images.iterdir() if p.suffix in (".png", ".jpg", ".webp")):
        image = cv2.cvtColor(cv2.imread(str(path), cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        shown = cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA) / 255.0
        shown = ((shown - mean) / deviation).astype(np.float32).transpose(2, 0, 1)[None]
        logits = model.run(None, {given.name: shown})[0][0]
        share = np.exp(logits - logits.max(axis=0))
        share = (share / share.sum(axis=0))[list(DYNAMIC_CLASSES["cityscapes256"])].sum(axis=0)
        share = cv2.resize(share, (image.shape[1], image.shape[0]), interpolation=cv2.INTER_LINEAR)
        label = np.where(share > 0.6, 255, np.where(share < 0.4, 0, 128)).astype(np.uint8)
        cv2.imwrite(str(args.out / f"{path.stem}.webp"), cv2.merge([label] * 3), [cv2.IMWRITE_WEBP_QUALITY, 101])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(required=True)
    one = commands.add_parser("loops", help="triplets of one sequence by place recognition")
    one.add_argument("--sequence", type=Path, required=True, help="folder of images")
    one.add_argument("--root", type=Path, required=True, help="paths in the list are relative to this folder")
    one.add_argument("--step", type=int, default=5, help="use every n-th frame")
    one.add_argument("--xfeat", type=Path, required=True, help="XFeat as ONNX")
    one.add_argument("--out", type=Path, required=True, help="list to write")
    one.set_defaults(run=loops)
    two = commands.add_parser("triplets", help="descriptors and matches of lists of triplets")
    two.add_argument("--csv", nargs="+", required=True, help="FILE:ROOT:LIMIT")
    two.add_argument("--xfeat", type=Path, required=True, help="XFeat as ONNX")
    add_folders(two)
    two.set_defaults(run=triplets)
    three = commands.add_parser("motion", help="motion labels of stereo sequences")
    three.add_argument("--sequence", nargs="+", required=True, help="FOLDER:STEP")
    three.add_argument("--labels", choices=("masks", "residuals"), default="masks", help="who says which vehicles move")
    add_folders(three)
    three.set_defaults(run=motion)
    five = commands.add_parser("vehicles", help="moving and standing points on vehicles of real sequences, to evaluate")
    five.add_argument("--names", nargs="+", required=True, help="sequences with pseudo-labels and stereo images")
    five.add_argument("--step", type=int, default=1, help="use every n-th labelled frame")
    add_folders(five)
    five.set_defaults(run=vehicles)
    four = commands.add_parser("semantic", help="stability maps by a segmenter")
    four.add_argument("--images", type=Path, required=True)
    four.add_argument("--segmenter", type=Path, required=True, help="Cityscapes segmenter as ONNX")
    four.add_argument("--out", type=Path, required=True)
    four.set_defaults(run=semantic)
    args = parser.parse_args()
    if hasattr(args, "cache"):
        need(parser, args, "cache")
    cv2.setNumThreads(1)
    args.run(args)


if __name__ == "__main__":
    main()
