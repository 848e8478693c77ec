"""Mixes the weights of a network with those of another that was trained further from it.

    python -m dsfeat.mixed --of BEFORE AFTER --share 0.8 --out mixed.pt

A short run on new material learns it and forgets a little of the old; between both weights much of the new is there and nearly all
of the old (Wortsman et al., *Robust fine-tuning of zero-shot models*, 2022). Both need the same normalizations, as a run with
`fixed_norms` keeps them.
"""

import argparse
from pathlib import Path

import torch

from .train_two import starting


def mixture(before: dict[str, torch.Tensor], after: dict[str, torch.Tensor], share: float) -> dict[str, torch.Tensor]:
    """Weights with the share `share` of `after`; counters are those of `before`."""
    return {k: torch.lerp(v, after[k], share) if v.is_floating_point() else v for k, v in before.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--of", type=Path, nargs=2, required=True, help="both networks: checkpoints or exported models")
    parser.add_argument("--share", type=float, required=True, help="share of the second one, 0 to 1")
    parser.add_argument("--doubt", type=float, default=0.0, help="taken off the logit of `dynamic`: the threshold of both answers")
    parser.add_argument("--out", type=Path, required=True, help="checkpoint to write")
    args = parser.parse_args()
    network = starting(args.of[0])
    network.load_state_dict(mixture(network.state_dict(), starting(args.of[1]).state_dict(), args.share))
    network.head.bias.data -= args.doubt
    torch.save({"network": network.state_dict()}, args.out)


if __name__ == "__main__":
    main()
