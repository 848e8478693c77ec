"""The activation network: a U-Net with fewer down-samplings, more depth and separable convolutions (paper, section II-B).

The vanilla U-Net halves the image four times with two plain convolutions per level. Here the image is halved three
times, the lowest level is several separable convolutions deep, most of them dilated (so that each pixel sees the street
around it), and a convolution with a sigmoid is the head.
"""

from pathlib import Path

import torch
from torch import nn
from torch.nn import functional as F

#: Network input, pixels: KITTI's 1226 x 370 at about a quarter.
HEIGHT, WIDTH = 96, 320
#: The activation map has the input's size divided by this.
STRIDE = 2
#: Channels at a half, a quarter and an eighth of the input's size, and the dilations of the lowest level's layers.
WIDTHS, DILATIONS = (8, 24, 64), (1, 2, 1, 4, 1, 4)
#: Grey values 0..1 are normalised inside the network.
MEAN, DEVIATION = 0.42, 0.24


class Pointwise(nn.Sequential):
    """1x1 convolution, normalised, rectified: [B, C_in, H, W] -> [B, C_out, H, W]."""

    def __init__(self, c_in: int, c_out: int):
        super().__init__(nn.Conv2d(c_in, c_out, 1, bias=False), nn.BatchNorm2d(c_out), nn.ReLU())


class Separable(nn.Module):
    """Depthwise 3x3 convolution, then 1x1 convolution, normalised: [B, C_in, H, W] -> [B, C_out, H/s, W/s].

    With equal shapes the input is added to the output.
    """

    def __init__(self, c_in: int, c_out: int, stride: int = 1, dilation: int = 1):
        super().__init__()
        self.depthwise = nn.Conv2d(c_in, c_in, 3, stride, dilation, dilation, groups=c_in, bias=False)
        self.pointwise = nn.Conv2d(c_in, c_out, 1, bias=False)
        self.norm = nn.BatchNorm2d(c_out)
        self.residual = stride == 1 and c_in == c_out

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        y = self.norm(self.pointwise(self.depthwise(x)))
        return F.relu(x + y if self.residual else y)


class Up(nn.Module):
    """Doubles the size of `x`, joins it with the encoder's map of that size and reduces both to `c_out` channels."""

    def __init__(self, c_in: int, c_skip: int, c_out: int, depth: int):
        super().__init__()
        self.reduce = Pointwise(c_in, c_out)
        self.join = nn.Sequential(Pointwise(c_out + c_skip, c_out), *[Separable(c_out, c_out) for _ in range(depth)])

    def forward(self, x: torch.Tensor, skip: torch.Tensor) -> torch.Tensor:
        x = F.interpolate(self.reduce(x), scale_factor=2.0, mode="bilinear", align_corners=False)
        return self.join(torch.cat([x, skip], dim=1))


class DSFeat(nn.Module):
    """Grey image [B, 1, H, W] in 0..1 -> logits of the activation [B, 1, H/2, W/2]; H and W are multiples of 8.

    `activation` gives the sigmoid of it, which is what the exported model returns.
    """

    def __init__(self, widths: tuple[int, int, int] = WIDTHS, dilations: tuple[int, ...] = DILATIONS):
        super().__init__()
        half, quarter, eighth = widths
        self.stem = nn.Sequential(nn.Conv2d(1, half, 3, 2, 1, bias=False), nn.BatchNorm2d(half), nn.ReLU())
        self.down_quarter = nn.Sequential(Separable(half, quarter, stride=2), Separable(quarter, quarter))
        self.down_eighth = nn.Sequential(
            Separable(quarter, eighth, stride=2), *[Separable(eighth, eighth, dilation=d) for d in dilations]
        )
        self.up_quarter = Up(eighth, quarter, quarter, depth=1)
        self.up_half = Up(quarter, half, half, depth=0)
        self.head = nn.Conv2d(half, 1, 3, 1, 1)

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        half = self.stem((image - MEAN) / DEVIATION)
        quarter = self.down_quarter(half)
        x = self.up_quarter(self.down_eighth(quarter), quarter)
        return self.head(self.up_half(x, half))

    def activation(self, image: torch.Tensor) -> torch.Tensor:
        """Static probability in 0..1, [B, 1, H/2, W/2]."""
        return torch.sigmoid(self(image))


class Exported(nn.Module):
    """`DSFeat` with the sigmoid, as exported to ONNX."""

    def __init__(self, network: DSFeat):
        super().__init__()
        self.network = network

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        return self.network.activation(image)


def restored(checkpoint: Path) -> DSFeat:
    """The network of a checkpoint of `dsfeat.train`, with its own widths and dilations."""
    state = torch.load(checkpoint, map_location="cpu", weights_only=True)
    network = DSFeat(*(tuple(state.get(key, default)) for key, default in (("widths", WIDTHS), ("dilations", DILATIONS))))
    network.load_state_dict(state["network"])
    return network


def multiply_adds(network: nn.Module, height: int = HEIGHT, width: int = WIDTH, channels: int = 1) -> int:
    """Multiplications with addition of all convolutions for one image; FLOP counts twice that."""
    total = 0

    def count(module: nn.Conv2d | nn.ConvTranspose2d, _inputs: tuple, output: torch.Tensor) -> None:
        nonlocal total
        kernel = module.kernel_size[0] * module.kernel_size[1] * module.in_channels // module.groups
        spread = module.stride[0] * module.stride[1] if isinstance(module, nn.ConvTranspose2d) else 1
        total += kernel * output[0].numel() // spread

    hooks = [m.register_forward_hook(count) for m in network.modules() if isinstance(m, (nn.Conv2d, nn.ConvTranspose2d))]
    was_training = network.training
    network.eval()
    with torch.no_grad():
        network(torch.zeros(1, channels, height, width))
    network.train(was_training)
    for hook in hooks:
        hook.remove()
    return total
