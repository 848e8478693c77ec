"""The network with two answers: what may move now, and what will still be there another day.

The encoder is EfficientNet-Lite0 up to its tenth block (ImageNet weights; its normalization is folded into the
convolutions), the decoder adds skips at 1/8, 1/4 and 1/2 of the input's size. Three heads share it:

- `dynamic`: the pixel belongs to a vehicle, a person or a bicycle (1/2 of the input's size);
- `moves`: if so, it moves now (1/8; sees the place in the frame and the whole scene);
- `known`: the scene is one that the network has learnt to judge (one number).

From them come the answers: `activation` = 1 - known * dynamic * moves, the paper's A, and `lasting` = 1 - known * dynamic.
Where the scene is not known both are 1: no opinion.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import nn
from torch.nn import functional as F

#: Pixels of the network's input in both presets; its sides are multiples of `UNIT` in the image's own proportions.
PIXELS = {"large": 128 * 416, "small": 96 * 320}
UNIT = 16
#: Gray values 0..1 are normalized as the mean of ImageNet's channels.
MEAN, DEVIATION = 0.449, 0.226
#: EfficientNet-Lite0's first eleven blocks: kernel, stride, expansion, channels.
BLOCKS = (
    (3, 1, 1, 16), (3, 2, 6, 24), (3, 1, 6, 24), (5, 2, 6, 40), (5, 1, 6, 40), (3, 2, 6, 80), (3, 1, 6, 80), (3, 1, 6, 80),
    (5, 1, 6, 112), (5, 1, 6, 112), (5, 1, 6, 112),
)
STEM = 32
#: Blocks whose outputs the decoder joins, and their channels: 1/2, 1/4, 1/8.
SKIPS, CHANNELS, DEEPEST = (0, 2, 4), (16, 24, 40), 112
#: Channels of the decoder at 1/2, 1/4, 1/8; dilations at 1/16; dilations of the head `moves` at 1/8.
WIDTHS, DILATIONS, LOOKS = (16, 24, 48), (2, 4), (1, 3)
#: Channels by which the scene as a whole is judged.
SCENE = 32
#: Epsilon of EfficientNet's normalization.
EPSILON = 1e-3


def size_for(aspect: float, pixels: int = PIXELS["large"]) -> tuple[int, int]:
    """Rows and columns of the network's input for images of this aspect (width over height)."""
    rows = max(UNIT, UNIT * math.floor(math.sqrt(pixels / aspect) / UNIT + 0.5))
    return rows, max(UNIT, UNIT * math.floor(pixels / rows / UNIT + 0.5))


@dataclass
class Logits:
    """`dynamic` [B, 1, H/2, W/2], `moves` [B, 1, H/2, W/2], `known` [B, 1, 1, 1]."""

    dynamic: torch.Tensor
    moves: torch.Tensor
    known: torch.Tensor

    def answers(self) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        """`activation` and `lasting` [B, 1, H/2, W/2], `known` [B, 1, 1, 1], all in 0..1."""
        known = torch.sigmoid(self.known)
        dynamic = known * torch.sigmoid(self.dynamic)
        return 1.0 - dynamic * torch.sigmoid(self.moves), 1.0 - dynamic, known


class Block(nn.Module):
    """Inverted bottleneck with folded normalization: expand, depthwise, project; added to its input where shapes agree."""

    def __init__(self, kernel: int, stride: int, expansion: int, c_in: int, c_out: int):
        super().__init__()
        middle = c_in * expansion
        self.expand = nn.Conv2d(c_in, middle, 1) if expansion > 1 else None
        self.depthwise = nn.Conv2d(middle, middle, kernel, stride, kernel // 2, groups=middle)
        self.project = nn.Conv2d(middle, c_out, 1)
        self.residual = stride == 1 and c_in == c_out

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        y = F.relu6(self.expand(x)) if self.expand is not None else x
        y = self.project(F.relu6(self.depthwise(y)))
        return x + y if self.residual else y


class Encoder(nn.Module):
    """Normalized gray image -> outputs of the blocks in `SKIPS` and of the last one (1/16)."""

    def __init__(self) -> None:
        super().__init__()
        self.stem = nn.Conv2d(1, STEM, 3, 2, 1)
        blocks, c_in = [], STEM
        for kernel, stride, expansion, c_out in BLOCKS:
            blocks.append(Block(kernel, stride, expansion, c_in, c_out))
            c_in = c_out
        self.blocks = nn.ModuleList(blocks)

    def forward(self, x: torch.Tensor) -> list[torch.Tensor]:
        x, found = F.relu6(self.stem(x)), []
        for i, block in enumerate(self.blocks):
            x = block(x)
            if i in SKIPS:
                found.append(x)
        return [*found, x]


class Separable(nn.Module):
    """Depthwise 3x3 and 1x1 convolution, normalized, added to the input, rectified."""

    def __init__(self, channels: int, dilation: int = 1):
        super().__init__()
        self.depthwise = nn.Conv2d(channels, channels, 3, 1, dilation, dilation, groups=channels, bias=False)
        self.pointwise = nn.Conv2d(channels, channels, 1, bias=False)
        self.norm = nn.BatchNorm2d(channels)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        return F.relu(x + self.norm(self.pointwise(self.depthwise(x))))


class Join(nn.Module):
    """Doubles `x`, adds the encoder's map of that size, both reduced to `c_out` channels."""

    def __init__(self, c_in: int, c_skip: int, c_out: int):
        super().__init__()
        self.reduce, self.skip = nn.Conv2d(c_in, c_out, 1, bias=False), nn.Conv2d(c_skip, c_out, 1, bias=False)
        self.norm = nn.BatchNorm2d(c_out)
        self.smooth = Separable(c_out)

    def forward(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        x = F.interpolate(self.reduce(x), scale_factor=2.0, mode="bilinear", align_corners=False)
        return self.smooth(F.relu(self.norm(x + self.skip(skip))))


class Moves(nn.Module):
    """Logit of moving at 1/8 from the decoder's map, the place in the frame and the scene as a whole."""

    def __init__(self, channels: int):
        super().__init__()
        self.place = nn.Conv2d(2, channels, 1, bias=False)
        self.scene = nn.Conv2d(DEEPEST, channels, 1, bias=False)
        self.own = nn.Conv2d(channels, channels, 1, bias=False)
        self.norm = nn.BatchNorm2d(channels)
        self.looks = nn.Sequential(*[Separable(channels, dilation=d) for d in LOOKS])
        self.head = nn.Conv2d(channels, 1, 1)

    def forward(self, x: torch.Tensor, scene: torch.Tensor, corners: torch.Tensor) -> torch.Tensor:
        return self.head(self.looks(F.relu(self.norm(self.own(x) + self.scene(scene) + self.place(corners)))))


def places(box: torch.Tensor | None, height: int | torch.Tensor, width: int | torch.Tensor) -> torch.Tensor:
    """Coordinates [B, 2, height, width] of the pixels of windows `box` [B, 4] (x, y, width, height: shares of the frame,
    a mirrored window has its width negative and x at its right edge): -1..1 over the whole frame. Without `box` the window is
    the whole frame, B is 1, and the exported graph has no products with 1 nor sums with 0, which runtimes tend to drop wrongly.
    """
    x = ((torch.arange(width) + 0.5) / width)[None]
    y = ((torch.arange(height) + 0.5) / height)[None]
    if box is not None:
        x, y = box[:, 0, None] + box[:, 2, None] * x, box[:, 1, None] + box[:, 3, None] * y
    xs = x[:, None, :].expand(-1, height, -1)
    ys = y[:, :, None].expand(-1, -1, width)
    return 2.0 * torch.stack([xs, ys], 1) - 1.0


class TwoAnswers(nn.Module):
    """Gray image [B, 1, H, W] in 0..1 -> `Logits`; H and W are multiples of 16.

    `box` says which window of its frame each image is (`places`); without it, the whole.
    """

    def __init__(self) -> None:
        super().__init__()
        half, quarter, eighth = WIDTHS
        self.encoder = Encoder()
        self.context = nn.Sequential(*[Separable(DEEPEST, dilation=d) for d in DILATIONS])
        self.up_eighth = Join(DEEPEST, CHANNELS[2], eighth)
        self.up_quarter = Join(eighth, CHANNELS[1], quarter)
        self.up_half = Join(quarter, CHANNELS[0], half)
        self.head = nn.Conv2d(half, 1, 1)
        self.moves = Moves(eighth)
        self.known = nn.Sequential(nn.Conv2d(DEEPEST, SCENE, 1), nn.ReLU(), nn.Conv2d(SCENE, 1, 1))

    def scene(self, image: torch.Tensor) -> torch.Tensor:
        """Mean of the deepest features, [B, 112, 1, 1]."""
        return F.adaptive_avg_pool2d(self.context(self.encoder((image - MEAN) / DEVIATION)[-1]), 1)

    def forward(self, image: torch.Tensor, box: torch.Tensor | None = None) -> Logits:
        half, quarter, eighth, deep = self.encoder((image - MEAN) / DEVIATION)
        deep = self.context(deep)
        scene = F.adaptive_avg_pool2d(deep, 1)
        middle = self.up_eighth(deep, eighth)
        moves = self.moves(middle, scene, places(box, image.shape[2] // 8, image.shape[3] // 8))
        moves = F.interpolate(moves, scale_factor=4.0, mode="bilinear", align_corners=False)
        dynamic = self.head(self.up_half(self.up_quarter(middle, quarter), half))
        # The scene's features are not moved by `known`: what the network knows is asked, not taught.
        return Logits(dynamic, moves, self.known(scene.detach()))


def folded(weights: dict[str, torch.Tensor], conv: str, norm: str) -> tuple[torch.Tensor, torch.Tensor]:
    """Weight and bias of a convolution with the normalization after it folded in."""
    scale = weights[f"{norm}.weight"] / (weights[f"{norm}.running_var"] + EPSILON).sqrt()
    return weights[f"{conv}.weight"] * scale[:, None, None, None], weights[f"{norm}.bias"] - weights[f"{norm}.running_mean"] * scale


def load_imagenet(encoder: Encoder, path: Path) -> None:
    """Loads the checkpoint of EfficientNet-Lite0; the stem is summed over the colors."""
    weights = torch.load(path, map_location="cpu", weights_only=True)

    def put(target: nn.Conv2d, conv: str, norm: str, gray: bool = False) -> None:
        weight, bias = folded(weights, conv, norm)
        target.weight.data.copy_(weight.sum(dim=1, keepdim=True) if gray else weight)
        target.bias.data.copy_(bias)

    put(encoder.stem, "_conv_stem", "_bn0", gray=True)
    for i, block in enumerate(encoder.blocks):
        name = f"_blocks.{i}"
        if block.expand is not None:
            put(block.expand, f"{name}._expand_conv", f"{name}._bn0")
        put(block.depthwise, f"{name}._depthwise_conv", f"{name}._bn1")
        put(block.project, f"{name}._project_conv", f"{name}._bn2")


def load_exported(network: "TwoAnswers", path: Path) -> None:
    """Loads an exported model. Normalizations that the export has folded into convolutions become the identity with a bias."""
    import onnx

    graph = onnx.load(str(path)).graph
    values = {i.name: torch.from_numpy(onnx.numpy_helper.to_array(i).copy()) for i in graph.initializer}
    state = network.state_dict()
    state.update({k.removeprefix("network."): v for k, v in values.items() if k.startswith("network.")})
    after = {name: node for node in graph.node for name in node.input if node.op_type == "Conv"}
    for node in graph.node:
        weight = node.input[1].removeprefix("network.") if node.op_type == "Conv" else ""
        name = weight.removesuffix(".depthwise.weight")
        if f"{name}.pointwise.weight" in state:
            _, folded_weight, folded_bias = after[node.output[0]].input
            state[f"{name}.pointwise.weight"], state[f"{name}.norm.bias"] = values[folded_weight], values[folded_bias]
            for key, value in (("weight", 1.0), ("running_mean", 0.0), ("running_var", 1.0 - 1e-5)):
                state[f"{name}.norm.{key}"] = torch.full_like(values[folded_bias], value)
    network.load_state_dict(state)


class Exported(nn.Module):
    """`TwoAnswers` as exported: `activation`, `lasting` and `known`."""

    def __init__(self, network: TwoAnswers):
        super().__init__()
        self.network = network

    def forward(self, image: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
        return self.network(image).answers()
