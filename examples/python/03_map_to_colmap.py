"""Read a map into numpy, print what is in it, and write it as a COLMAP model in text form.

    python 03_map_to_colmap.py map.dsmap fx fy cx cy width height colmap_folder
"""

import pathlib
import sys

import numpy as np

import dsslam

map_file, *numbers, folder = sys.argv[1:]
fx, fy, cx, cy, width, height = map(float, numbers)
folder = pathlib.Path(folder)
folder.mkdir(parents=True, exist_ok=True)

town = dsslam.Map.load(map_file)
seen = town.observations
print(town)
print(f"each point is seen {len(seen['point']) / town.n_points:.1f} times; median activation {np.median(town.activation):.2f}")


def quaternion(rotation):
    """w, x, y, z of a rotation matrix."""
    w = np.sqrt(max(0.0, 1 + np.trace(rotation))) / 2
    if w > 1e-3:
        x, y, z = (
            (rotation[2, 1] - rotation[1, 2]) / (4 * w),
            (rotation[0, 2] - rotation[2, 0]) / (4 * w),
            (rotation[1, 0] - rotation[0, 1]) / (4 * w),
        )
        return np.array([w, x, y, z])
    values, vectors = np.linalg.eigh(rotation + rotation.T)
    return np.array([0.0, *vectors[:, -1]])


(folder / "cameras.txt").write_text(f"1 PINHOLE {width:.0f} {height:.0f} {fx} {fy} {cx} {cy}\n")

with (folder / "images.txt").open("w") as file:
    for row, (pose, frame) in enumerate(zip(town.keyframe_poses, town.keyframe_frames)):
        cam_from_world = np.linalg.inv(pose)
        numbers = [*quaternion(cam_from_world[:3, :3]), *cam_from_world[:3, 3]]
        file.write(f"{row + 1} {' '.join(f'{n:.9g}' for n in numbers)} 1 {frame:06d}.png\n")
        mine = seen["keyframe"] == row
        entries = zip(seen["pixel"][mine], town.point_ids[seen["point"][mine]])
        # COLMAP's pixels begin at the corner of the first pixel, ours at its center.
        file.write(" ".join(f"{x + 0.5:.3f} {y + 0.5:.3f} {point}" for (x, y), point in entries) + "\n")

place = np.zeros(len(seen["point"]), dtype=int)  # index of each observation within its keyframe
for row in range(town.n_keyframes):
    mine = seen["keyframe"] == row
    place[mine] = np.arange(mine.sum())
order = np.argsort(seen["point"], kind="stable")
starts = np.searchsorted(seen["point"][order], np.arange(town.n_points + 1))
with (folder / "points3D.txt").open("w") as file:
    for row, (point, position) in enumerate(zip(town.point_ids, town.points)):
        track = order[starts[row] : starts[row + 1]]
        pairs = " ".join(f"{seen['keyframe'][i] + 1} {place[i]}" for i in track)
        file.write(f"{point} {' '.join(f'{v:.9g}' for v in position)} 128 128 128 1.0 {pairs}\n")
print(f"written: {folder}/cameras.txt, images.txt, points3D.txt")
