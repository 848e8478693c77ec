"""Area under the ROC curve and intersection over union of activation maps."""

import numpy as np

#: Activations are counted in this many bins for the AUC: error below 1e-3.
BINS = 4096


class Tally:
    """Histograms of activations of two kinds of pixels: `high` should have higher values than `low`."""

    def __init__(self) -> None:
        self.high = np.zeros(BINS, np.int64)
        self.low = np.zeros(BINS, np.int64)

    def add(self, activation: np.ndarray, high: np.ndarray, low: np.ndarray) -> None:
        """Adds a map (0..1) with the boolean maps of both kinds, all of one shape."""
        bins = np.minimum((activation * BINS).astype(np.int64), BINS - 1)
        self.high += np.bincount(bins[high], minlength=BINS)
        self.low += np.bincount(bins[low], minlength=BINS)

    def auc(self) -> float:
        """Probability that a `high` pixel has a higher activation than a `low` one, ties counting half."""
        total = float(self.high.sum()) * float(self.low.sum())
        if total == 0.0:
            return float("nan")
        below = np.cumsum(self.low) - self.low
        return float((self.high * (below + 0.5 * self.low)).sum() / total)

    def iou(self, threshold: float = 0.5) -> tuple[float, float]:
        """Intersection over union of (`high`, `low`) when the activation is cut at `threshold`."""
        cut = int(round(threshold * BINS))
        high_right, high_wrong = float(self.high[cut:].sum()), float(self.high[:cut].sum())
        low_right, low_wrong = float(self.low[:cut].sum()), float(self.low[cut:].sum())
        every = high_wrong + low_wrong
        return high_right / max(high_right + every, 1.0), low_right / max(low_right + every, 1.0)

    def means(self) -> tuple[float, float]:
        """Mean activation of both kinds."""
        centres = (np.arange(BINS) + 0.5) / BINS
        return tuple(float((h * centres).sum() / h.sum()) if h.sum() else float("nan") for h in (self.high, self.low))
