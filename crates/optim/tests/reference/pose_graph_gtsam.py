"""Independent solution of pose graphs by GTSAM (pip install gtsam; 4.3.0).

    python pose_graph_gtsam.py sphere2500.g2o parking-garage.g2o smallGrid3D.g2o

Prints half the sum of squared whitened residuals at the file's values and at the end, by Gauss-Newton and by
Levenberg-Marquardt, and the times. The costs are constants in tests/pose_graph_files.rs.
"""

import sys
import time

import gtsam


def read(path):
    graph, initial = gtsam.readG2o(path, True)
    # A constraint of its own, so that the cost of the gauge is exactly zero.
    graph.add(gtsam.NonlinearEqualityPose3(0, initial.atPose3(0)))
    return graph, initial


def optimizer(name, graph, initial):
    if name == "GN":
        params = gtsam.GaussNewtonParams()
        make = gtsam.GaussNewtonOptimizer
    else:
        params = gtsam.LevenbergMarquardtParams()
        make = gtsam.LevenbergMarquardtOptimizer
    params.setMaxIterations(200)
    params.setRelativeErrorTol(1e-12)
    params.setAbsoluteErrorTol(1e-12)
    return make(graph, initial, params)


def main():
    for path in sys.argv[1:]:
        graph, initial = read(path)
        print(f"{path}: initial cost {graph.error(initial):.12e}")
        for name in ("GN", "LM"):
            begin, begin_wall = time.process_time(), time.perf_counter()
            solver = optimizer(name, graph, initial)
            result = solver.optimize()
            cpu, wall = time.process_time() - begin, time.perf_counter() - begin_wall
            print(
                f"  {name}: final cost {graph.error(result):.12e}  {solver.iterations()} iterations"
                f"  {cpu:.3f} s processor, {wall:.3f} s wall"
            )


if __name__ == "__main__":
    main()
