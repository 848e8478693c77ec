"""Run DSSLAM over a folder of images and plot the trajectory from above.

    python 01_folder_to_plot.py path/to/sequence trajectory_plot.png
"""

import sys

import matplotlib

matplotlib.use("Agg")  # writes files, needs no screen
import matplotlib.pyplot as plt

import dsslam

folder, picture = sys.argv[1:3]


def progress(kind, what):
    if kind == "frame":
        print(f"\rframe {what.index}: {what.state}", end="", flush=True)


done = dsslam.run(folder, observer=progress)
print(f"\n{done}")

times, poses = done.trajectory()
x, z = poses[:, 0, 3], poses[:, 2, 3]
figure, axes = plt.subplots(figsize=(7, 7))
axes.plot(x, z, label="estimate")
axes.set_aspect("equal", adjustable="datalim")
axes.set_xlabel("x [m]")
axes.set_ylabel("z [m]")
title = f"{len(times)} poses"
if done.evaluation:
    title += f", ATE {done.evaluation['ate_m']['rmse']:.3f} m"
axes.set_title(title)
axes.legend()
figure.savefig(picture, dpi=150)
print(f"written: {picture}")
