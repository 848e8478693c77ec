"""Compares segmentation backbones at 256x256 with the semantic loss only (the paper's table of backbones).

    python -m dsfeat.backbones --cache CACHE --json backbones.json [--steps 200]

Each result is written as soon as it is there; what the file already has from as many steps is not trained again.

Small versions of SegNet (pooling indices), U-Net (four down-samplings) and DeepLab v3 (dilated pyramid), each with about
the same width, trained equally long on CamVid or Cityscapes (static/dynamic), and our network. IoU is the mean over
static and dynamic, FPS is measured with ONNX-free PyTorch on one thread.
"""

import argparse
import json
import time
from pathlib import Path

import cv2
import numpy as np
import torch
from torch import nn
from torch.nn import functional as F

from . import losses
from .augment import light
from .data import DYNAMIC, STATIC, Scenes, add_folders, load, need
from .metrics import Tally
from .network import DSFeat, multiply_adds

SIZE = 256
#: Channels of the levels.
WIDTHS = (16, 32, 64, 96, 128)


def block(c_in: int, c_out: int, dilation: int = 1) -> nn.Sequential:
    """Two plain 3x3 convolutions, as in SegNet and U-Net: [B, C_in, H, W] -> [B, C_out, H, W]."""
    layers: list[nn.Module] = []
    for a in (c_in, c_out):
        layers += [nn.Conv2d(a, c_out, 3, 1, dilation, dilation, bias=False), nn.BatchNorm2d(c_out), nn.ReLU()]
    return nn.Sequential(*layers)


class SegNet(nn.Module):
    """Encoder and decoder without skip connections; the decoder puts values back where pooling took them from."""

    def __init__(self) -> None:
        super().__init__()
        widths = [1, *WIDTHS]
        self.encoder = nn.ModuleList(block(a, b) for a, b in zip(widths, widths[1:]))
        back = [*reversed(WIDTHS)]
        self.decoder = nn.ModuleList(block(a, b) for a, b in zip(back, [*back[1:], back[-1]]))
        self.head = nn.Conv2d(back[-1], 1, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        places = []
        for layer in self.encoder:
            x, place = F.max_pool2d(layer(x), 2, return_indices=True)
            places.append(place)
        for layer in self.decoder:
            x = layer(F.max_unpool2d(x, places.pop(), 2))
        return self.head(x)


class UNet(nn.Module):
    """The vanilla U-Net: four down-samplings, skip connections by concatenation."""

    def __init__(self) -> None:
        super().__init__()
        widths = [1, *WIDTHS]
        self.encoder = nn.ModuleList(block(a, b) for a, b in zip(widths, widths[1:]))
        back = [*reversed(WIDTHS)]
        self.up = nn.ModuleList(nn.ConvTranspose2d(a, b, 2, 2) for a, b in zip(back, back[1:]))
        self.decoder = nn.ModuleList(block(2 * b, b) for b in back[1:])
        self.head = nn.Conv2d(back[-1], 1, 1)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        kept = []
        for i, layer in enumerate(self.encoder):
            x = layer(x if i == 0 else F.max_pool2d(x, 2))
            kept.append(x)
        kept.pop()
        for up, layer in zip(self.up, self.decoder):
            x = layer(torch.cat([up(x), kept.pop()], dim=1))
        return self.head(x)


class DeepLab(nn.Module):
    """DeepLab v3: stride 8, then dilated blocks and a pyramid of dilated convolutions with global pooling."""

    def __init__(self) -> None:
        super().__init__()
        a, b, c, d, e = WIDTHS
        self.encoder = nn.Sequential(
            block(1, a), nn.MaxPool2d(2), block(a, b), nn.MaxPool2d(2), block(b, c), nn.MaxPool2d(2), block(c, d, 2), block(d, e, 4)
        )
        self.pyramid = nn.ModuleList(
            [nn.Conv2d(e, c, 1, bias=False)] + [nn.Conv2d(e, c, 3, 1, k, k, bias=False) for k in (3, 6, 9)]
        )
        self.whole = nn.Conv2d(e, c, 1)
        self.norm = nn.BatchNorm2d(5 * c)
        self.head = nn.Sequential(nn.Conv2d(5 * c, c, 1, bias=False), nn.BatchNorm2d(c), nn.ReLU(), nn.Conv2d(c, 1, 1))

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        size = x.shape[2:]
        x = self.encoder(x)
        whole = self.whole(x.mean(dim=(2, 3), keepdim=True)).expand(-1, -1, *x.shape[2:])
        x = F.relu(self.norm(torch.cat([*(layer(x) for layer in self.pyramid), whole], dim=1)))
        return F.interpolate(self.head(x), size=size, mode="bilinear", align_corners=False)


def wide() -> DSFeat:
    """Our network as the hybrid run has it."""
    return DSFeat((12, 32, 80), (1, 2, 4, 8, 1, 2, 4, 8))


BACKBONES = {"SegNet": SegNet, "U-Net": UNet, "DeepLab v3": DeepLab, "ours": DSFeat, "ours, wide": wide}


def square(scenes: Scenes, i: int) -> tuple[np.ndarray, np.ndarray]:
    """Frame and stability map at 256x256."""
    image = cv2.resize(scenes.images[i], (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    return image, cv2.resize(scenes.maps[i], (SIZE, SIZE), interpolation=cv2.INTER_NEAREST)


def train(network: nn.Module, scenes: Scenes, steps: int, batch: int, seed: int) -> None:
    """Trains with eq. 1 only; the rate falls to a tenth for the last quarter."""
    optimiser = torch.optim.Adam(network.parameters(), lr=1e-3)
    schedule = torch.optim.lr_scheduler.MultiStepLR(optimiser, [3 * steps // 4], 0.1)
    network.train()
    for step in range(steps):
        rng = np.random.default_rng((seed, step))
        pairs = [square(scenes, int(rng.integers(len(scenes)))) for _ in range(batch)]
        flips = rng.random(batch) < 0.5
        images = np.stack([light(rng, p[0][:, ::-1] if f else p[0]) for p, f in zip(pairs, flips)])
        maps = torch.from_numpy(np.stack([p[1][:, ::-1] if f else p[1] for p, f in zip(pairs, flips)]))
        logits = network(torch.from_numpy(images)[:, None].contiguous(memory_format=torch.channels_last))
        maps = F.interpolate(maps[:, None].float(), size=logits.shape[2:], mode="nearest")[:, 0]
        loss = losses.semantic(logits, maps, 1.0)
        optimiser.zero_grad(set_to_none=True)
        loss.backward()
        optimiser.step()
        schedule.step()


def measure(network: nn.Module, scenes: Scenes, limit: int) -> dict[str, float]:
    """Mean IoU and AUC on at most `limit` frames, and frames per second on one thread."""
    network.eval()
    tally = Tally()
    for i in np.linspace(0, len(scenes) - 1, min(limit, len(scenes))).round().astype(int):
        image, labels = square(scenes, i)
        with torch.no_grad():
            found = torch.sigmoid(network(torch.from_numpy(image.astype(np.float32) / 255.0)[None, None]))
        found = F.interpolate(found, size=(SIZE, SIZE), mode="bilinear", align_corners=False)[0, 0].numpy()
        tally.add(found, labels == STATIC, labels == DYNAMIC)
    static, dynamic = tally.iou()
    image = torch.rand(1, 1, SIZE, SIZE)
    times = []
    with torch.no_grad():
        for _ in range(12):
            start = time.process_time()
            network(image)
            times.append(time.process_time() - start)
    return {"mean_iou": 0.5 * (static + dynamic), "iou_dynamic": dynamic, "auc": tally.auc(), "fps": 1.0 / min(times)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=200, help="optimisation steps per backbone and data set")
    parser.add_argument("--only", nargs="*", choices=list(BACKBONES), default=list(BACKBONES), help="backbones to train")
    parser.add_argument("--batch", type=int, default=8)
    parser.add_argument("--limit", type=int, default=200, help="frames to evaluate per data set")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, help="file to write the numbers to")
    add_folders(parser)
    args = parser.parse_args()
    need(parser, args, "cache")
    torch.set_num_threads(1)
    found: dict[str, dict] = json.loads(args.json.read_text()) if args.json and args.json.is_file() else {}
    for data, validation in (("camvid_train", "camvid_test"), ("cityscapes_train", "cityscapes_val")):
        missing = [name for name in args.only if found.get(validation, {}).get(name, {}).get("steps") != args.steps]
        if not missing:
            continue
        scenes, held_out = load(data, args.cache), load(validation, args.cache)
        for name in missing:
            torch.manual_seed(args.seed)
            network = BACKBONES[name]().to(memory_format=torch.channels_last)
            train(network, scenes, args.steps, args.batch, args.seed)
            result = measure(network, held_out, args.limit) | {"steps": args.steps}
            result["parameters"] = sum(p.numel() for p in network.parameters())
            result["gflop"] = 2e-9 * multiply_adds(network, SIZE, SIZE)
            found.setdefault(validation, {})[name] = {k: round(v, 4) for k, v in result.items()}
            print(f"{validation:15} {name:11}", " ".join(f"{k} {v:.3f}" for k, v in result.items()), flush=True)
            if args.json:
                args.json.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
