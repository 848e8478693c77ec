"""Independent solution of a "bundle adjustment in the large" problem with numpy and scipy.

    python bal_scipy.py ladybug-49-7776.txt

Levenberg-Marquardt to convergence with derivatives by complex steps (exact to rounding). scipy.optimize.least_squares (trf,
lsmr, x_scale="jac") creeps on this problem: it stands at 1.33896e4 after 400 evaluations. GTSAM drops observations behind the
camera, and so minimises something else. Prints half the sum of squared residuals at the start and at the end, and the
time. The end is the constant in tests/bal.rs.
"""

import sys
import time

import numpy as np
import scipy.linalg
from scipy.sparse import bsr_matrix, csr_matrix

STEP = 1e-30


def read(path):
    with open(path) as file:
        n_cameras, n_points, n = (int(x) for x in file.readline().split())
        rows = np.array([file.readline().split() for _ in range(n)], float)
        values = np.array(file.read().split(), float)
    cameras = values[: 9 * n_cameras].reshape(-1, 9)
    points = values[9 * n_cameras :].reshape(n_points, 3)
    return cameras, points, rows[:, 0].astype(int), rows[:, 1].astype(int), rows[:, 2:]


def cross(a, b):
    parts = [a[:, (i + 1) % 3] * b[:, (i + 2) % 3] - a[:, (i + 2) % 3] * b[:, (i + 1) % 3] for i in range(3)]
    return np.stack(parts, 1)


def project(camera, point):
    """Pixels by the model's definition; complex arguments are allowed, none of the rotations is zero."""
    theta = np.sqrt(np.sum(camera[:, :3] ** 2, 1))[:, None]
    axis = camera[:, :3] / theta
    p = point * np.cos(theta) + cross(axis, point) * np.sin(theta)
    p = p + axis * np.sum(axis * point, 1)[:, None] * (1 - np.cos(theta)) + camera[:, 3:6]
    p = -p[:, :2] / p[:, 2:]
    m = np.sum(p * p, 1)
    return p * (camera[:, 6] * (1 + camera[:, 7] * m + camera[:, 8] * m * m))[:, None]


def main():
    cameras, points, camera_of, point_of, measured = read(sys.argv[1])
    n_camera_values = cameras.size
    n = len(measured)

    def residuals(x):
        c, p = x[:n_camera_values].reshape(-1, 9), x[n_camera_values:].reshape(-1, 3)
        return (project(c[camera_of], p[point_of]) - measured).ravel()

    rows = np.repeat(np.arange(2 * n).reshape(n, 2, 1), 12, axis=2)
    columns = np.hstack([9 * camera_of[:, None] + np.arange(9), n_camera_values + 3 * point_of[:, None] + np.arange(3)])
    columns = np.repeat(columns[:, None, :], 2, axis=1)

    def jacobian(x):
        c, p = x[:n_camera_values].reshape(-1, 9), x[n_camera_values:].reshape(-1, 3)
        out = np.empty((n, 2, 12))
        for k in range(12):
            moved = [c[camera_of].astype(complex), p[point_of].astype(complex)]
            moved[k // 9][:, k % 9] += 1j * STEP
            out[:, :, k] = project(*moved).imag / STEP
        return csr_matrix((out.ravel(), (rows.ravel(), columns.ravel())), shape=(2 * n, x.size))

    def step(jac, r, damping):
        """Solves (J^T J + damping diag(J^T J)) dx = -J^T r by the Schur complement of the points."""
        by_camera, by_point = jac[:, :n_camera_values], jac[:, n_camera_values:]
        u = (by_camera.T @ by_camera).toarray()
        u += damping * np.diag(np.diag(u))
        v = np.zeros((len(points), 3, 3))
        np.add.at(v, point_of, np.einsum("nik,nil->nkl", *[by_point.data.reshape(n, 2, 3)] * 2))
        v *= 1 + damping * np.eye(3)
        v_inv = bsr_matrix((np.linalg.inv(v), np.arange(len(points)), np.arange(len(points) + 1))).tocsr()
        w = (by_camera.T @ by_point).tocsr()
        g_camera, g_point = by_camera.T @ r, by_point.T @ r
        factor = scipy.linalg.cho_factor(u - (w @ v_inv @ w.T).toarray())
        dc = -scipy.linalg.cho_solve(factor, g_camera - w @ (v_inv @ g_point))
        return np.concatenate([dc, -v_inv @ (g_point + w.T @ dc)])

    x = np.concatenate([cameras.ravel(), points.ravel()])
    begin = time.process_time()
    r, damping, n_steps = residuals(x), 1e-4, 0
    cost = 0.5 * r @ r
    print(f"initial cost {cost:.9e}")
    jac = jacobian(x)
    while n_steps < 300 and damping < 1e12:
        n_steps += 1
        try:
            trial = x + step(jac, r, damping)
        except scipy.linalg.LinAlgError:
            damping *= 4
            continue
        trial_r = residuals(trial)
        trial_cost = 0.5 * trial_r @ trial_r
        if not trial_cost < cost:
            damping *= 4
            continue
        gain = cost - trial_cost
        x, r, cost, jac, damping = trial, trial_r, trial_cost, jacobian(trial), max(damping / 3, 1e-9)
        if gain < 1e-9 * cost:
            break
    print(f"final cost   {cost:.9e}  steps {n_steps}  {time.process_time() - begin:.1f} s processor time")


if __name__ == "__main__":
    main()
