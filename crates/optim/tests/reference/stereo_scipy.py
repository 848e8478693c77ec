"""Independent solution of a stereo bundle adjustment: scipy's trust region method with a sparse Jacobian.

    cargo run -p optim --example write_stereo_problem -- problem.txt
    python stereo_scipy.py problem.txt

Prints half the sum of squared whitened residuals at the start and at the end, and the time. The end is the constant in
tests/stereo_reference.rs.
"""

import sys
import time

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import csr_matrix

STEP = 1e-30


def read(path):
    with open(path) as file:
        fx, fy, cx, cy, bf = (float(x) for x in file.readline().split())
        n_cameras, n_points, n = (int(x) for x in file.readline().split())
        cameras = np.array([file.readline().split() for _ in range(n_cameras)], float)
        points = np.array([file.readline().split() for _ in range(n_points)], float)
        rows = np.array([file.readline().split() for _ in range(n)], float)
    return (fx, fy, cx, cy, bf), cameras, points, rows


def cross(a, b):
    parts = [a[..., (i + 1) % 3] * b[..., (i + 2) % 3] - a[..., (i + 2) % 3] * b[..., (i + 1) % 3] for i in range(3)]
    return np.stack(parts, -1)


def rotate(omega, x):
    """exp([omega]x) x by the power series of sin(t)/t and (1 - cos t)/t^2: valid for complex arguments."""
    t = np.sum(omega * omega, -1, keepdims=True)
    a = b = 0
    for k in reversed(range(12)):
        a = 1 - t * a / ((2 * k + 2) * (2 * k + 3))
        b = 1 - t * b / ((2 * k + 3) * (2 * k + 4))
    c = cross(omega, x)
    return x + a * c + 0.5 * b * cross(omega, c)


def main():
    (fx, fy, cx, cy, bf), cameras, points, rows = read(sys.argv[1])
    fixed = cameras[:, 0] > 0
    rotation, translation = cameras[:, 1:10].reshape(-1, 3, 3), cameras[:, 10:13]
    camera_of, point_of, measured = rows[:, 0].astype(int), rows[:, 1].astype(int), rows[:, 2:5]
    whiten = np.sqrt(rows[:, 5])[:, None] * ~np.isnan(measured)
    measured = np.nan_to_num(measured)
    n, n_camera_values = len(rows), 6 * len(cameras)

    def project(motion, x):
        """Residuals for a motion [omega, shift] after the initial pose and a point in the world."""
        p = np.einsum("nij,nj->ni", rotation[camera_of], x) + translation[camera_of]
        p = rotate(motion[:, :3], p) + motion[:, 3:]
        u = fx * p[:, 0] / p[:, 2] + cx
        v = fy * p[:, 1] / p[:, 2] + cy
        return whiten * (np.stack([u, v, u - bf / p[:, 2]], -1) - measured)

    def split(x):
        return x[:n_camera_values].reshape(-1, 6)[camera_of], x[n_camera_values:].reshape(-1, 3)[point_of]

    def residuals(x):
        return project(*split(x)).ravel()

    columns = np.hstack([6 * camera_of[:, None] + np.arange(6), n_camera_values + 3 * point_of[:, None] + np.arange(3)])
    columns = np.repeat(columns[:, None, :], 3, axis=1)
    lines = np.repeat(np.arange(3 * n).reshape(n, 3, 1), 9, axis=2)
    is_free = np.ones((n, 3, 9), bool)
    is_free[fixed[camera_of], :, :6] = False

    def jacobian(x):
        motion, point = split(x)
        out = np.empty((n, 3, 9))
        for k in range(9):
            moved = [motion.astype(complex), point.astype(complex)]
            moved[k // 6][:, k % 6] += 1j * STEP
            out[:, :, k] = project(*moved).imag / STEP
        return csr_matrix((out[is_free], (lines[is_free], columns[is_free])), shape=(3 * n, x.size))

    start = np.concatenate([np.zeros(n_camera_values), points.ravel()])
    begin = time.perf_counter()
    result = least_squares(
        residuals, start, jac=jacobian, x_scale="jac", method="trf", ftol=1e-11, xtol=1e-15, gtol=1e-15,
        max_nfev=100, tr_solver="lsmr", tr_options={"maxiter": 2000},
    )
    seconds = time.perf_counter() - begin
    print(f"initial cost {0.5 * np.sum(residuals(start) ** 2):.12e}")
    print(f"final cost   {result.cost:.12e}  status {result.status}  evaluations {result.nfev}  {seconds:.1f} s")


if __name__ == "__main__":
    main()
