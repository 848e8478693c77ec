"""Independent solution of a stereo bundle adjustment by GTSAM (pip install gtsam; 4.3.0).

    cargo run -p optim --example write_stereo_problem -- problem.txt
    python stereo_gtsam.py problem.txt

Prints half the sum of squared whitened residuals at the start and at the end, and the time. Both are constants in
tests/stereo_reference.rs.
"""

import math
import sys
import time

import gtsam
import numpy as np
from gtsam.symbol_shorthand import P, X


def main():
    graph, initial = gtsam.NonlinearFactorGraph(), gtsam.Values()
    with open(sys.argv[1]) as file:
        fx, fy, cx, cy, bf = (float(x) for x in file.readline().split())
        stereo, mono = gtsam.Cal3_S2Stereo(fx, fy, 0, cx, cy, bf / fx), gtsam.Cal3_S2(fx, fy, 0, cx, cy)
        n_cameras, n_points, n = (int(x) for x in file.readline().split())
        for i in range(n_cameras):
            row = [float(x) for x in file.readline().split()]
            cam_from_world = gtsam.Pose3(gtsam.Rot3(np.array(row[1:10]).reshape(3, 3)), np.array(row[10:13]))
            world_from_cam = cam_from_world.inverse()
            initial.insert(X(i), world_from_cam)
            if row[0] > 0:
                graph.add(gtsam.NonlinearEqualityPose3(X(i), world_from_cam))
        for j in range(n_points):
            initial.insert(P(j), np.array([float(x) for x in file.readline().split()]))
        for _ in range(n):
            i, j, u, v, right_u, inv_sigma_sq = (float(x) for x in file.readline().split())
            sigma = 1 / math.sqrt(inv_sigma_sq)
            keys = X(int(i)), P(int(j))
            if math.isnan(right_u):
                noise = gtsam.noiseModel.Isotropic.Sigma(2, sigma)
                graph.add(gtsam.GenericProjectionFactorCal3_S2(np.array([u, v]), noise, *keys, mono))
            else:
                noise = gtsam.noiseModel.Isotropic.Sigma(3, sigma)
                graph.add(gtsam.GenericStereoFactor3D(gtsam.StereoPoint2(u, right_u, v), noise, *keys, stereo))
    params = gtsam.LevenbergMarquardtParams.CeresDefaults()
    params.setMaxIterations(200)
    params.setRelativeErrorTol(1e-13)
    params.setAbsoluteErrorTol(1e-10)
    begin = time.process_time()
    optimizer = gtsam.LevenbergMarquardtOptimizer(graph, initial, params)
    result = optimizer.optimize()
    seconds = time.process_time() - begin
    print(f"initial cost {graph.error(initial):.12e}")
    print(f"final cost   {graph.error(result):.12e}  iterations {optimizer.iterations()}  {seconds:.1f} s processor time")


if __name__ == "__main__":
    main()
