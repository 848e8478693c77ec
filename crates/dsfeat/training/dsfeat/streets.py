"""Frames of streets with what each pixel is and whether it moves, for the network with two answers.

    python -m dsfeat.streets --outlines LABELS [--states states.csv]

Codes of a pixel: 0 ignored, 1 static, 2 standing vehicle, 3 moving vehicle or person, 4 vehicle of which nobody knows
whether it moves. Class labels of the datasets give 1 and 4 (people 3); in KITTI's frames the outlines come from the
vote of the teachers (`dsfeat.teachers`) and the state from the motion labels or from `states.csv`, a list of vehicles that
were looked at (file, x, y, state: a point of the label file, `s` standing or `m` moving).
"""

import argparse
import csv
import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from .data import DYNAMIC_CLASSES, IGNORED_CLASSES, add_folders, need, read_classes, read_grey, resize_pair, spread

IGNORED, STILL, STANDING, MOVING, VEHICLE = range(5)
#: Values of the motion labels (`motion/`).
UNKNOWN, LABEL_STATIC, LABEL_STANDING, LABEL_MOVING = range(4)
#: Classes of people (and of riders), who move.
PEOPLE = {"cityscapes256": (11, 12), "idd_lite": (2,), "camvid": (9, 10)}
#: Riders and two-wheelers of the data sets that tell them apart: one with a rider moves, one without anybody about stands.
RIDERS = {"cityscapes256": (12, (17, 18), 11)}
#: Reach in pixels of a rider or a walker to a two-wheeler, and of the known pixels into the unlabeled seams between them.
REACH, SEAM = 3, 3
#: Size (width, height) and aspect of the frames of each source.
FORMS = {
    "cityscapes256": ((256, 256), 2.0), "idd_lite": ((320, 227), 320 / 227), "camvid": ((480, 360), 4 / 3),
    "kitti": ((620, 188), 1241 / 376), "davis": ((427, 240), 427 / 240), "town": ((620, 188), 1241 / 376),
}
#: Pseudo-labeled KITTI drives, by the name of the drive in the motion labels where it is one of those.
PSEUDO = {"kittiraw_0926_0009": "Seq009", "kitti_alike": "alike", "sfnd_kitti_mono78_rgb": "Seq095"}
MOTION = ("kt3dmoseg", "semantickitti", "parked", "davis")
#: The drives of the motion labels in three thirds, each left out in turn.
THIRDS = (
    ("Seq009", "kitti03", "kitti10", "car-roundabout", "drift-straight"),
    ("Seq013", "Seq037", "Seq071", "kitti06", "car-shadow"),
    ("Seq020", "Seq045", "Seq070", "Seq095", "Seq113", "p268", "kitti09", "drift-chicane", "scooter-black"),
)
#: Presets of `dsslam synth` that surround the camera with vehicles, of whose courses every n-th frame is used; the seed that only
#: measures.
TRAFFIC, TRAFFIC_STEP, CHOSEN_ON = ("jam", "lorry", "column", "trams"), 4, 71
#: A region of the teachers' takes a state of the motion labels if this share of it has one and this share of that agrees.
KNOWN, AGREED = 0.15, 0.7


@dataclass
class Frames:
    """Images and codes [N, H, W] uint8 of one aspect, the drive of each frame."""

    name: str
    images: np.ndarray
    codes: np.ndarray
    drives: np.ndarray
    aspect: float

    def __len__(self) -> int:
        return len(self.images)

    def of(self, chosen: np.ndarray) -> "Frames":
        """The frames at `chosen`."""
        return Frames(self.name, self.images[chosen], self.codes[chosen], self.drives[chosen], self.aspect)


def class_codes(labels: np.ndarray, source: str) -> np.ndarray:
    """Codes of a class map."""
    table = np.full(256, STILL, np.uint8)
    table[list(DYNAMIC_CLASSES[source])] = VEHICLE
    table[list(PEOPLE.get(source, ()))] = MOVING
    table[list(IGNORED_CLASSES[source])] = IGNORED
    return with_two_wheelers(table[labels], labels, source)


def with_two_wheelers(codes: np.ndarray, labels: np.ndarray, source: str) -> np.ndarray:
    """Gives two-wheelers the state that their riders tell; where only a walker is near nobody knows."""
    if source not in RIDERS:
        return codes
    rider, wheels, walker = RIDERS[source]
    reach = np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8)
    ours = np.isin(labels, wheels)
    near = cv2.dilate((ours | (labels == rider)).astype(np.uint8), reach)
    count, found = cv2.connectedComponents(near, connectivity=4)
    ridden, walked = (np.bincount(found[where], minlength=count) > 0 for where in (labels == rider, labels == walker))
    table = np.where(ridden, MOVING, np.where(walked, VEHICLE, STANDING)).astype(np.uint8)
    return np.where(ours, table[found], codes)


def without_seams(codes: np.ndarray) -> np.ndarray:
    """Codes in which unlabeled pixels close to labeled ones have the nearest one's code.

    In Cityscapes' copy nearly all pixels next to a vehicle are unlabeled: a network that never sees them lets its vehicles grow.
    """
    distance, nearest = cv2.distanceTransformWithLabels(
        (codes == IGNORED).astype(np.uint8), cv2.DIST_L2, 3, labelType=cv2.DIST_LABEL_PIXEL
    )
    table = np.zeros(int(nearest.max()) + 1, np.uint8)
    table[nearest[codes != IGNORED]] = codes[codes != IGNORED]
    return np.where((codes == IGNORED) & (distance <= SEAM), table[nearest], codes)


def mended(codes: np.ndarray, source: str) -> np.ndarray:
    """Codes to train on: without seams, and in Cityscapes' copy without threads."""
    closed = without_seams(codes)
    return np.where(threads(codes == VEHICLE), IGNORED, closed) if source == "cityscapes256" else closed


def threads(vehicles: np.ndarray) -> np.ndarray:
    """Vehicles of which no part is 3 pixels wide and high: wires and seams whose mixed colors read as one."""
    ours = vehicles.astype(np.uint8)
    count, found = cv2.connectedComponents(ours, connectivity=4)
    solid = np.bincount(found[cv2.erode(ours, np.ones((3, 3), np.uint8)) > 0], minlength=count) > 0
    return vehicles & ~solid[found]


def vote_codes(vote: np.ndarray) -> np.ndarray:
    """Codes of a map of the teachers (0 static, 128 not decided, 255 dynamic)."""
    return np.where(vote == 255, VEHICLE, np.where(vote == 128, IGNORED, STILL)).astype(np.uint8)


def with_fourth(codes: np.ndarray, static: np.ndarray, dynamic: np.ndarray) -> np.ndarray:
    """Codes after a fourth vote, that of the labels which came with the frame (their own segmenter was another one).

    It decides what the teachers left open; where it alone contradicts them, nobody is believed.
    """
    out = np.where(codes == IGNORED, np.where(static, STILL, np.where(dynamic, VEHICLE, IGNORED)), codes)
    return np.where(((codes == VEHICLE) & static) | ((codes == STILL) & dynamic), IGNORED, out).astype(np.uint8)


def regions(codes: np.ndarray) -> tuple[int, np.ndarray]:
    """Connected regions of vehicles: their number (with 0, the rest) and the map of their numbers."""
    return cv2.connectedComponents((codes == VEHICLE).astype(np.uint8), connectivity=4)


def with_states(codes: np.ndarray, states: list[tuple[float, float, str]]) -> np.ndarray:
    """Gives the vehicles at points (shares of width and height) their state, `s` or `m`, or `x`: ignored."""
    if not states:
        return codes
    _, found = regions(codes)
    out = codes.copy()
    for x, y, state in states:
        region = found[min(int(y * codes.shape[0]), codes.shape[0] - 1), min(int(x * codes.shape[1]), codes.shape[1] - 1)]
        if region:
            out[found == region] = {"s": STANDING, "m": MOVING, "x": IGNORED}[state]
    return out


def with_motion(codes: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Gives the vehicles that the teachers outline the state of the motion labels.

    A pixel that both call a vehicle has the label's state; the rest of a region follows where most of the region agrees.
    """
    stated = (motion == LABEL_STANDING) | (motion == LABEL_MOVING)
    codes = with_fourth(codes, motion == LABEL_STATIC, stated)
    count, found = regions(codes)
    every, moving, standing = (
        np.bincount(found[chosen], minlength=count)
        for chosen in (codes == VEHICLE, (codes == VEHICLE) & (motion == LABEL_MOVING), (codes == VEHICLE) & (motion == LABEL_STANDING))
    )
    table, known = np.full(count, VEHICLE, np.uint8), moving + standing
    enough = known >= KNOWN * np.maximum(every, 1)
    table[enough & (moving >= AGREED * known)] = MOVING
    table[enough & (standing >= AGREED * known)] = STANDING
    out = np.where(codes == VEHICLE, table[found], codes)
    return np.where((codes == VEHICLE) & stated, np.where(motion == LABEL_MOVING, MOVING, STANDING), out).astype(np.uint8)


def with_mover(codes: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Codes where the motion label holds the exact mask of one mover (DAVIS)."""
    out = np.where((motion == UNKNOWN) & (codes == STILL), IGNORED, codes)
    return np.where(motion == LABEL_MOVING, MOVING, out).astype(np.uint8)


def drive_of(stem: str) -> str:
    """Drive of a frame of the motion labels: the clips of one drive belong together."""
    return re.sub(r"(_Clip\d+)?_\d+(_cam2)?$", "", stem)


def read_states(path: Path | None) -> dict[str, list[tuple[float, float, str]]]:
    """States of vehicles that were looked at, by label file."""
    found = defaultdict(list)
    if path is not None:
        with path.open(newline="") as file:
            for row in csv.DictReader(file):
                found[row["file"]].append((float(row["x"]), float(row["y"]), row["state"]))
    return found


def collect(name: str, form: str, rows: list[tuple[Path, np.ndarray, str]]) -> Frames:
    """Frames of (image file, codes, drive), brought to the form's size.

    Raises SystemExit where there is none.
    """
    if not rows:
        raise SystemExit(f"{name}: no frames found")
    size, aspect = FORMS[form]
    read = [resize_pair(read_grey(path), codes, size) for path, codes, _ in rows]
    images, codes = (np.stack(x) for x in zip(*read))
    return Frames(name, images, codes, np.array([drive for _, _, drive in rows]), aspect)


def photographs(source: str, part: str, training: Path) -> Frames:
    """A data set with class labels, mended where it is trained on."""
    rows = []
    for path in sorted((training / source / part / "label").glob("*.webp")):
        codes = class_codes(read_classes(path), source)
        codes = mended(codes, source) if part == "train" else codes
        rows.append((path.parent.parent / "image" / path.name, codes, path.stem.split("_")[0]))
    return collect(f"{source}_{part}", source, rows)


def looked(source: str, training: Path, states: dict) -> Frames:
    """The photographs of a data set whose vehicles were looked at."""
    rows = []
    for name in sorted(n for n in states if n.startswith(f"{source}/train")):
        path = training / name
        codes = mended(with_states(class_codes(read_classes(path), source), states[name]), source)
        rows.append((path.parent.parent / "image" / path.name, codes, path.stem.split("_")[0]))
    return collect(f"{source}_looked", source, rows)


def pseudo(training: Path, outlines: Path, states: dict, most: int | None = None) -> Frames:
    """The pseudo-labeled KITTI drives that come with images, outlined by the teachers; at most `most` frames of each."""
    rows = []
    for name, drive in PSEUDO.items():
        for path in spread(sorted((training / "kitti_pseudo" / name / "image").glob("*.webp")), most):
            codes = vote_codes(read_classes(outlines / name / f"{path.stem}.png"))
            label = f"kitti_pseudo/{name}/label/{path.name}"
            theirs = cv2.resize(read_classes(training / label), codes.shape[::-1], interpolation=cv2.INTER_NEAREST)
            codes = with_fourth(codes, theirs == 0, theirs == 255)
            rows.append((path, with_states(codes, states.get(label, [])), drive))
    return collect("pseudo", "kitti", rows)


def motion(source: str, training: Path, outlines: Path, most: int | None = None) -> Frames:
    """Real frames with motion labels, outlined by the teachers; at most `most` of them."""
    rows = []
    for path in spread(sorted((training / "motion" / "train" / source / "label").glob("*.webp")), most):
        label, vote = read_classes(path), read_classes(outlines / source / f"{path.stem}.png")
        codes = (with_mover if source == "davis" else with_motion)(vote_codes(vote), label)
        rows.append((path.parent.parent / "image" / path.name, codes, drive_of(path.stem)))
    return collect(source, "davis" if source == "davis" else "kitti", rows)


def labeled(source: str, training: Path, sequences: Path) -> Frames:
    """Real frames with the motion labels as they are, to evaluate: `dev` or a source of the training frames."""
    table = np.full(256, IGNORED, np.uint8)
    table[[LABEL_STATIC, LABEL_STANDING, LABEL_MOVING]] = STILL, STANDING, MOVING
    if source == "dev":
        labels = sorted((training / "motion" / "dev" / "kittiraw_0005" / "label").glob("*.webp"))
        images = sorted((sequences / "kittiraw_0005" / "image_0").glob("*.png"))
        rows = [(images[int(p.stem.split("_")[1])], table[read_classes(p)], "0005") for p in labels]
    else:
        labels = sorted((training / "motion" / "train" / source / "label").glob("*.webp"))
        rows = [(p.parent.parent / "image" / p.name, table[read_classes(p)], drive_of(p.stem)) for p in labels]
    return collect(source if source == "dev" else f"labeled_{source}", "davis" if source == "davis" else "kitti", rows)


def town_rows(folder: Path, step: int) -> list[tuple[Path, np.ndarray, str]]:
    """Every `step`-th frame of a rendered town, with its exact masks (0 still, 1 moving, 2 parked, 3 sky)."""
    table = np.array([STILL, MOVING, STANDING, STILL], np.uint8)
    return [
        (folder / "image_0" / path.name, table[read_classes(path)], folder.name)
        for path in sorted((folder / "masks").glob("*.png"))[::step]
    ]


def town(folder: Path, step: int) -> Frames:
    """Every `step`-th frame of a rendered town."""
    return collect(f"town_{folder.name}", "town", town_rows(folder, step))


def traffic(name: str, towns: Path, step: int) -> Frames:
    """Every `step`-th frame of the rendered courses whose view traffic fills: `traffic` of those to train on, `traffic_dev` of
    those by which choices are made (`CHOSEN_ON`).
    """
    folders = [f for f in sorted(towns.iterdir()) if f.name.split("_")[0] in TRAFFIC and (f / "masks").is_dir()]
    chosen = [f for f in folders if (int(f.name.split("_")[1]) == CHOSEN_ON) == (name == "traffic_dev")]
    return collect(name, "town", [row for folder in chosen for row in town_rows(folder, step)])


def save(frames: Frames, cache: Path) -> None:
    """Writes frames into the cache."""
    np.savez(
        cache / f"streets_{frames.name}.npz", images=frames.images, codes=frames.codes, drives=frames.drives, aspect=frames.aspect
    )
    shares = " ".join(f"{(frames.codes == code).mean():.2%}" for code in range(5))
    print(f"{frames.name}: {len(frames)} frames, codes 0 to 4: {shares}", flush=True)


def load(name: str, cache: Path) -> Frames:
    """Frames from the cache."""
    path = cache / f"streets_{name}.npz"
    if not path.is_file():
        raise SystemExit(f"{path}: not there; run `python -m dsfeat.streets` first")
    with np.load(path) as file:
        return Frames(name, file["images"], file["codes"], file["drives"], float(file["aspect"]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--outlines", type=Path, required=True, help="folder of the teachers' maps, one folder for each source")
    parser.add_argument("--states", type=Path, help="list of vehicles that were looked at")
    parser.add_argument("--step", type=int, default=4, help="use every n-th frame of a rendered town")
    parser.add_argument("--most", type=int, help="use at most this many of each folder of outlined frames, as dsfeat.teachers does")
    parser.add_argument("--only", nargs="*", help="names of sets to build")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "training", "sequences", "towns", "cache")
    args.cache.mkdir(parents=True, exist_ok=True)
    states = read_states(args.states)
    jobs = {
        f"{source}_{part}": lambda s=source, p=part: photographs(s, p, args.training)
        for source, parts in (("cityscapes256", "train val"), ("idd_lite", "train val"), ("camvid", "train val test"))
        for part in parts.split()
    }
    if states:
        jobs["cityscapes256_looked"] = lambda: looked("cityscapes256", args.training, states)
    jobs["pseudo"] = lambda: pseudo(args.training, args.outlines, states, args.most)
    jobs.update({source: lambda s=source: motion(s, args.training, args.outlines, args.most) for source in MOTION})
    jobs["dev"] = lambda: labeled("dev", args.training, args.sequences)
    jobs.update({f"labeled_{source}": lambda s=source: labeled(s, args.training, args.sequences) for source in MOTION})
    jobs.update({n: lambda n=n: traffic(n, args.towns, TRAFFIC_STEP) for n in ("traffic", "traffic_dev")})
    for folder in sorted(args.towns.iterdir()):
        if (folder / "masks").is_dir() and folder.name.split("_")[0] not in TRAFFIC:
            jobs[f"town_{folder.name}"] = lambda f=folder: town(f, args.step)
    for name, job in jobs.items():
        if not args.only or name in args.only:
            save(job(), args.cache)


if __name__ == "__main__":
    main()
