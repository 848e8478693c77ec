"""Fits the head that says whether a scene is one the network has learnt to judge, on the features of a trained network.

    python -m dsfeat.known --checkpoint runs/two/last.pt --strange FOLDER FOLDER --out runs/two/known.pt

Known are the streets of the training sets in any light; strange are the frames of the given folders (halls, offices, works),
of which the last third is kept aside to measure, and streets that stand on their head or lie on their side. Only the head
`known` changes: the answers in a known scene stay as they were.
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from torch.nn import functional as F

from . import streets
from .data import add_folders, need, read_grey
from .train_two import starting
from .two_answers import SCENE, TwoAnswers, size_for
from .views import light, view, whole

#: Sets of known scenes; those of the second line only measure.
KNOWN = ("cityscapes256_train", "idd_lite_train", "camvid_train", "pseudo", "kt3dmoseg", "semantickitti", "parked", "davis", "traffic")
MEASURED = ("cityscapes256_val", "idd_lite_val", "camvid_val", "camvid_test", "dev", "traffic_dev")
#: Share of the frames of a strange folder that are trained on.
SHOWN = 2 / 3
#: Steps of the fit, and the weight of a known scene: to doubt a street costs more than to judge a hall.
STEPS, WEIGHT = 400, 2.0


def features(network: TwoAnswers, images: list[np.ndarray]) -> torch.Tensor:
    """Scene features [N, 112] of float32 images."""
    with torch.no_grad():
        return torch.cat([network.scene(torch.from_numpy(image)[None, None]).flatten(1) for image in images])


def fed(image: np.ndarray) -> np.ndarray:
    """The whole of a uint8 image as the program feeds it."""
    return whole(image, size_for(image.shape[1] / image.shape[0]))


def known_views(rng: np.random.Generator, cache: Path, each: int, names: tuple[str, ...], changed: bool) -> list[np.ndarray]:
    """`each` frames of each set, as augmented views or whole."""
    found = []
    for name in names:
        frames = streets.load(name, cache)
        size = size_for(frames.aspect)
        for i in rng.permutation(len(frames))[:each]:
            image, codes = frames.images[i], frames.codes[i]
            found.append(view(rng, image, codes, frames.aspect, size, 0.6, True).image if changed else whole(image, size))
    return found


def turned(rng: np.random.Generator, images: list[np.ndarray]) -> list[np.ndarray]:
    """Images on their head or on their side."""
    return [np.ascontiguousarray(np.rot90(image, rng.integers(1, 4))) for image in images]


def strange_frames(folders: list[Path], most: int) -> dict[str, list[np.ndarray]]:
    """At most `most` evenly spread gray frames of each folder, in order."""
    found = {}
    for folder in folders:
        paths = sorted((p for p in folder.iterdir() if p.suffix in (".png", ".jpg", ".webp")), key=lambda p: (len(p.name), p.name))
        chosen = np.linspace(0, len(paths) - 1, min(most, len(paths))).round().astype(int)
        found[str(folder)] = [read_grey(paths[i]) for i in chosen]
    return found


def strange_view(rng: np.random.Generator, image: np.ndarray) -> np.ndarray:
    """A window of a strange frame in another light."""
    rows, columns = image.shape
    y, x = (int(rng.uniform(0, 0.25) * n) for n in (rows, columns))
    part = image[y : y + int(rng.uniform(0.7, 1.0) * (rows - y)), x : x + int(rng.uniform(0.7, 1.0) * (columns - x))]
    return light(rng, np.rint(255 * fed(part)).astype(np.uint8))


def fit(network: TwoAnswers, known: torch.Tensor, strange: torch.Tensor) -> None:
    """Trains the head on features; the standardization is folded into its first layer."""
    every = torch.cat([known, strange])
    mean, deviation = every.mean(dim=0), every.std(dim=0) + 1e-3
    torch.manual_seed(1)
    layers = torch.nn.Sequential(torch.nn.Linear(every.shape[1], SCENE), torch.nn.ReLU(), torch.nn.Linear(SCENE, 1))
    optimizer = torch.optim.AdamW(layers.parameters(), lr=1e-2, weight_decay=1e-2)
    target = torch.cat([torch.ones(len(known)), torch.zeros(len(strange))])
    weight = torch.where(target > 0, WEIGHT / len(known), 1.0 / len(strange)) * len(every)
    shown = (every - mean) / deviation
    for _ in range(STEPS):
        loss = F.binary_cross_entropy_with_logits(layers(shown + 0.1 * torch.randn_like(shown))[:, 0], target, weight)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    first = layers[0].weight.data / deviation
    network.known[0].weight.data.copy_(first[:, :, None, None])
    network.known[0].bias.data.copy_(layers[0].bias.data - first @ mean)
    network.known[2].weight.data.copy_(layers[2].weight.data[:, :, None, None])
    network.known[2].bias.data.copy_(layers[2].bias.data)


def report(network: TwoAnswers, name: str, found: torch.Tensor) -> None:
    """Mean of `known` and how many frames are judged known."""
    with torch.no_grad():
        known = torch.sigmoid(network.known(found[:, :, None, None]).flatten())
    print(f"{name}: {len(found)} frames, known {known.mean():.3f}, above one half {(known > 0.5).float().mean():.1%}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--checkpoint", type=Path, required=True, help="checkpoint of dsfeat.train_two")
    parser.add_argument("--strange", type=Path, nargs="+", required=True, help="folders of frames in which it shall have no opinion")
    parser.add_argument("--aside", type=Path, nargs="*", default=[], help="folders of strange frames that only measure")
    parser.add_argument("--each", type=int, default=60, help="frames of each set and folder")
    parser.add_argument("--out", type=Path, required=True, help="checkpoint to write")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "cache")
    torch.set_num_threads(1)
    network = starting(args.checkpoint).eval()
    rng = np.random.default_rng(1)
    roads = known_views(rng, args.cache, args.each, KNOWN, True)
    others, held = turned(rng, roads[::4]), {}
    for name, frames in strange_frames(args.strange, args.each).items():
        shown = round(SHOWN * len(frames))
        others += [strange_view(rng, frame) for frame in frames[:shown] for _ in range(2)]
        held[f"{name} (last third)"] = frames[shown:]
    held.update(strange_frames(args.aside, args.each))
    fit(network, features(network, roads), features(network, others))
    torch.save({"network": network.state_dict()}, args.out)
    for name in MEASURED:
        report(network, name, features(network, known_views(rng, args.cache, 40, (name,), False)))
    for name, frames in held.items():
        report(network, name, features(network, [fed(frame) for frame in frames]))


if __name__ == "__main__":
    main()
