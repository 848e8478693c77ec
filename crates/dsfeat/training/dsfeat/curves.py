"""Training curves as a small PNG."""

from pathlib import Path


def plot(rows: list[dict], path: Path, title: str) -> None:
    """Losses (left) and validation numbers (right) over the epochs; `rows` are those of `log.csv`."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    epochs = [row["epoch"] for row in rows]
    for name in ("semantic", "dense", "sparse", "motion"):
        values = [row[name] for row in rows]
        if any(values):
            left.plot(epochs, values, label=name)
    left.plot(epochs, [row["weight_semantic"] for row in rows], "k:", label="weight of the semantic loss")
    left.set(xlabel="epoch", ylabel="loss", title=f"{title}: losses")
    left.legend()
    names = sorted({k for row in rows for k in row if k.endswith(("auc", "auc_parked_moving"))})
    for name in names:
        points = [(row["epoch"], row[name]) for row in rows if name in row]
        style = "--" if name.startswith("town") else "-"
        right.plot(*zip(*points), style, label=name.replace("_parked_moving", " parked/moving").replace(":auc", ""))
    right.set(xlabel="epoch", ylabel="pixel AUC", title="16 frames of each validation set", ylim=(0.0, 1.0))
    right.legend(fontsize="small", loc="lower right")
    figure.savefig(path, dpi=80)
    plt.close(figure)
