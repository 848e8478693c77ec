#!/usr/bin/env python3
"""KITTI odometry drift by its definition alone (numpy, no code shared with the library): t_rel [%], r_rel [deg/100 m].

usage: devkit_reference.py GROUND_TRUTH ESTIMATE [--sim3] [--lengths 10,20]

Files are KITTI poses; the estimate may carry a frame number in front of the 12 values. --sim3 moves both to their first
common frame and aligns the estimate's positions by Umeyama's similarity before the drift, as monocular tables do.
Prints: t_rel, r_rel, RMS of t, standard deviation of t, number of segments, ATE.
"""
import sys

import numpy as np


def read(path):
    poses = {}
    for i, row in enumerate(np.loadtxt(path)):
        frame = int(row[0]) if len(row) == 13 else i
        poses[frame] = np.vstack([row[-12:].reshape(3, 4), [0, 0, 0, 1]])
    return poses


def umeyama(src, dst):
    ms, md = src.mean(0), dst.mean(0)
    u, d, vt = np.linalg.svd((dst - md).T @ (src - ms) / len(src))
    s = np.diag([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    rotation = u @ s @ vt
    scale = np.trace(np.diag(d) @ s) / ((src - ms) ** 2).sum(1).mean()
    return scale, rotation, md - scale * rotation @ ms


def align(gt, est):
    frames = sorted(est)
    gt0, est0 = np.linalg.inv(gt[frames[0]]), np.linalg.inv(est[frames[0]])
    gt = {i: gt0 @ p for i, p in gt.items()}
    est = {i: est0 @ p for i, p in est.items()}
    scale, rotation, t = umeyama(np.array([est[i][:3, 3] for i in frames]), np.array([gt[i][:3, 3] for i in frames]))
    for i, p in est.items():
        moved = np.eye(4)
        moved[:3, :3] = rotation @ p[:3, :3]
        moved[:3, 3] = scale * rotation @ p[:3, 3] + t
        est[i] = moved
    return gt, est


def drift(gt, est, lengths):
    position = np.array([gt[i][:3, 3] for i in range(len(gt))])
    d = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(position, axis=0), axis=1))])
    t_errors, r_errors = [], []
    for i in range(0, len(gt), 10):
        for length in lengths:
            beyond = [j for j in range(i, len(gt)) if d[j] > d[i] + length][:1]
            if not beyond or i not in est or beyond[0] not in est:
                continue
            j = beyond[0]
            error = np.linalg.inv(np.linalg.inv(est[i]) @ est[j]) @ (np.linalg.inv(gt[i]) @ gt[j])
            t_errors.append(np.linalg.norm(error[:3, 3]) / length)
            r_errors.append(np.arccos(np.clip((np.trace(error[:3, :3]) - 1) / 2, -1, 1)) / length)
    return np.array(t_errors), np.array(r_errors)


def main():
    gt, est = read(sys.argv[1]), read(sys.argv[2])
    lengths = [100.0 * k for k in range(1, 9)]
    if "--lengths" in sys.argv:
        lengths = [float(v) for v in sys.argv[sys.argv.index("--lengths") + 1].split(",")]
    if "--sim3" in sys.argv:
        gt, est = align(gt, est)
    t, r = drift(gt, est, lengths)
    squared = [((gt[i][:3, 3] - est[i][:3, 3]) ** 2).sum() for i in sorted(est)]
    values = [100 * t.mean(), np.degrees(r.mean()) * 100, 100 * np.sqrt((t**2).mean()), 100 * t.std(), len(t)]
    print(*(repr(float(v)) for v in [*values, np.sqrt(np.mean(squared))]))


main()
