"""How far a pose is to be trusted."""

import csv

import numpy as np
from conftest import push
from test_run import program, town  # noqa: F401

import dsslam

AXES = ["x", "y", "z", "rx", "ry", "rz"]


def is_covariance(matrix):
    return matrix.shape == (6, 6) and np.array_equal(matrix, matrix.T) and np.linalg.eigvalsh(matrix).min() > 0


def table(results):
    """The rows of frames.csv, with the covariance as a matrix, or None."""
    rows = list(csv.DictReader(open(results / "frames.csv", newline="")))
    for row in rows:
        row["covariance"] = None
        if row["cov_xx"]:
            matrix = np.zeros((6, 6))
            for i in range(6):
                for k in range(i, 6):
                    matrix[i, k] = matrix[k, i] = float(row[f"cov_{AXES[i]}{AXES[k]}"])
            row["covariance"] = matrix
    return rows


def test_each_tracked_frame_has_a_covariance(slam, frames):
    results = push(slam, frames)
    assert results[0].covariance is None and results[0].quality == 1.0, "the first frame is the origin"
    for result in results[1:]:
        assert is_covariance(result.covariance), result
        assert 0 < result.quality <= 1 and result.residual_px < 1.0
        turn = np.kron(np.eye(2), result.pose[:3, :3])
        assert np.allclose(result.covariance_world, turn @ result.covariance @ turn.T)
    # Centimeters and hundredths of a degree over less than a second.
    sigma = np.sqrt(np.diag(results[-1].covariance))
    assert sigma[:3].max() < 0.1 and np.degrees(sigma[3:]).max() < 0.2


def test_a_lost_frame_has_none(slam, frames):
    push(slam, frames)
    t_ns, left, right = frames[-1]
    lost = slam.track(t_ns + 100_000_000, np.full_like(left, 90), np.full_like(right, 90))
    assert lost.state == "lost"
    assert lost.covariance is None and lost.covariance_world is None and lost.residual_px is None
    assert lost.quality == 0 and lost.quality_reasons == []


def test_the_table_of_the_program_has_the_same(town, tmp_path):  # noqa: F811
    seen = {}
    done = dsslam.run(town, observer=lambda kind, what: seen.update({what.index: what}) if kind == "frame" else None)
    out = tmp_path / "of_program"
    assert program("run", town, "--quiet", "--out", out).returncode == 0
    rows = table(out)
    assert len(rows) == len(seen) == len(done.frames) == 40
    with_covariance = 0
    for row, final in zip(rows, done.frames):
        live = seen[int(row["frame"])]
        assert live.quality == final["quality"] == float(row["quality"])
        assert live.quality_reasons == final["quality_reasons"] == [r for r in row["quality_reasons"].split(";") if r]
        if live.covariance is None:
            assert row["covariance"] is None and final["covariance"] is None
            continue
        with_covariance += 1
        assert np.array_equal(live.covariance, row["covariance"])
        assert np.array_equal(live.covariance, final["covariance"])
    assert with_covariance >= 38
