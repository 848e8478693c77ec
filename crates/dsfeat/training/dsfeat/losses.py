"""The losses of the paper: semantic (eq. 1), triplet matching (eq. 2 to 6), hybrid (eq. 7), and the motion loss.

Two of the paper's formulas have a trivial minimum at zero activation everywhere (eq. 3 and 4 are proportional to the
activation). Here the weights of one image, or of the matches of one pair, are normalised to mean 1, so that only their
distribution counts.
"""

import torch
from torch.nn import functional as F

from . import streets
from .motion import IGNORED, MOVED, STANDING

#: Least mean of weights before normalisation.
FLOOR = 1e-3


def semantic(logits: torch.Tensor, maps: torch.Tensor, dynamic_weight: float) -> torch.Tensor:
    """Binary cross entropy of eq. 1: logits [B, 1, H, W], maps [B, H, W] with 0 dynamic, 1 static, 2 ignored."""
    known = (maps != 2).to(logits.dtype)
    target = (maps == 1).to(logits.dtype)
    weight = known * torch.where(maps == 0, dynamic_weight, 1.0)
    loss = F.binary_cross_entropy_with_logits(logits[:, 0], target, weight, reduction="sum")
    return loss / weight.sum().clamp(min=1.0)


def normalised(weights: torch.Tensor, valid: torch.Tensor | None = None) -> torch.Tensor:
    """Weights [B, ...] divided by their mean over all but the first axis (over `valid` ones where given)."""
    flat = weights.flatten(1)
    if valid is None:
        mean = flat.mean(dim=1)
    else:
        chosen = valid.flatten(1).to(flat.dtype)
        flat = flat * chosen
        mean = flat.sum(dim=1) / chosen.sum(dim=1).clamp(min=1.0)
    return (flat / mean.clamp(min=FLOOR)[:, None]).reshape(weights.shape)


def dense_distance(
    activation_1: torch.Tensor, descriptors_1: torch.Tensor, activation_2: torch.Tensor, descriptors_2: torch.Tensor
) -> torch.Tensor:
    """Eq. 3: distance [B] of the activation-weighted mean descriptors.

    Activations [B, 1, H, W] are averaged to the descriptors' size [B, C, h, w].
    """
    means = []
    for activation, descriptors in ((activation_1, descriptors_1), (activation_2, descriptors_2)):
        weight = normalised(F.adaptive_avg_pool2d(activation, descriptors.shape[2:]))
        means.append((weight * descriptors).mean(dim=(2, 3)))
    return (means[0] - means[1]).square().sum(dim=1).add(1e-12).sqrt()


def at_points(maps: torch.Tensor, points: torch.Tensor) -> torch.Tensor:
    """Samples maps [B, 1, H, W] bilinearly at points [B, N, 2], (x, y) in -1..1 from edge to edge: [B, N]."""
    return F.grid_sample(maps, points[:, None], mode="bilinear", padding_mode="border", align_corners=False)[:, 0, 0]


def sparse_distance(
    activation_1: torch.Tensor, points_1: torch.Tensor, activation_2: torch.Tensor, points_2: torch.Tensor,
    errors: torch.Tensor, valid: torch.Tensor,
) -> torch.Tensor:
    """Eq. 4 and 5: mean epipolar error [B] of the matches, weighted by the activation at both ends.

    `errors` [B, N] are the two-sided errors of eq. 6 per match, cut and scaled to 0..1, `valid` [B, N] says which
    entries are matches. A pair without any match has the largest distance, 1.
    """
    weight = at_points(activation_1, points_1) * at_points(activation_2, points_2)
    weight = normalised(weight.clamp(min=1e-12).sqrt(), valid)
    count = valid.to(errors.dtype).sum(dim=1)
    mean = (weight * errors * valid.to(errors.dtype)).sum(dim=1) / count.clamp(min=1.0)
    return torch.where(count > 0, mean, 1.0)


def triplet(positive: torch.Tensor, negative: torch.Tensor, margin: float) -> torch.Tensor:
    """Eq. 2: mean over the batch of max(d(q, p) - d(q, n) + margin, 0)."""
    return F.relu(positive - negative + margin).mean()


def motion(logits: torch.Tensor, maps: torch.Tensor, moved: float, standing: float) -> torch.Tensor:
    """Cross entropy with maps refined by motion: logits [B, 1, H, W], maps [B, H, W] (values of `dsfeat.motion`).

    Pixels that moved have target 0 and weight `moved`, those on standing vehicles target 1 and weight `standing`.
    """
    weight = torch.ones_like(logits[:, 0])
    for value, factor in ((MOVED, moved), (STANDING, standing), (IGNORED, 0.0)):
        weight = torch.where(maps == value, factor, weight)
    target = (maps != MOVED).to(logits.dtype)
    loss = F.binary_cross_entropy_with_logits(logits[:, 0], target, weight, reduction="sum")
    return loss / weight.sum().clamp(min=1.0)


def semantic_weight(epoch: int, decay: float, floor: float) -> float:
    """Weight of the semantic loss in epoch 0, 1, ...; eq. 7 with alpha = 1 - this."""
    return max(decay**epoch, floor)


def hybrid(semantic_loss: torch.Tensor, matching_loss: torch.Tensor, weight: float) -> torch.Tensor:
    """Eq. 7 with alpha = 1 - weight: the semantic loss leads first, the matching loss later."""
    return weight * semantic_loss + (1.0 - weight) * matching_loss


def lasting(dynamic: torch.Tensor, codes: torch.Tensor, dynamic_weight: float) -> torch.Tensor:
    """Eq. 1 for the answer "another day": logits of dynamic classes [B, 1, H, W], codes of `dsfeat.streets` [B, H, W]."""
    weight = torch.where(codes >= streets.STANDING, dynamic_weight, 1.0) * (codes != streets.IGNORED)
    target = (codes >= streets.STANDING).to(dynamic.dtype)
    loss = F.binary_cross_entropy_with_logits(dynamic[:, 0], target, weight, reduction="sum")
    return loss / weight.sum().clamp(min=1.0)


def moves(logits: torch.Tensor, codes: torch.Tensor, few: float = 60.0) -> torch.Tensor:
    """Cross entropy of moving against standing on vehicles whose state is known; images with few such pixels count less."""
    known = ((codes == streets.STANDING) | (codes == streets.MOVING)).to(logits.dtype)
    target = (codes == streets.MOVING).to(logits.dtype)
    loss = F.binary_cross_entropy_with_logits(logits[:, 0], target, known, reduction="none").sum(dim=(1, 2))
    count = known.sum(dim=(1, 2))
    return (loss / (count + few)).sum() / (count > 0).sum().clamp(min=1)


def now(activation: torch.Tensor, codes: torch.Tensor, moved: float, standing: float) -> torch.Tensor:
    """Cross entropy of the activation [B, 1, H, W] with 0 on what moves and 1 on all else whose state is known."""
    weight = torch.zeros_like(activation[:, 0])
    for code, factor in ((streets.STILL, 1.0), (streets.STANDING, standing), (streets.MOVING, moved)):
        weight = torch.where(codes == code, factor, weight)
    target = (codes != streets.MOVING).to(activation.dtype)
    loss = F.binary_cross_entropy(activation[:, 0].clamp(1e-4, 1 - 1e-4), target, weight, reduction="sum")
    return loss / weight.sum().clamp(min=1.0)
