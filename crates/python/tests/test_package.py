"""The package: its types, its doctests, its examples, the code of its pages."""

import ast
import doctest
import pathlib
import re
import subprocess
import sys

import numpy as np
from conftest import ROOT

import dsslam

STUB = pathlib.Path(dsslam.__file__).with_suffix(".pyi")


def example(name, *arguments, cwd):
    file = ROOT / "examples/python" / name
    ran = subprocess.run([sys.executable, file, *map(str, arguments)], capture_output=True, text=True, cwd=cwd)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return ran.stdout


def test_the_stub_has_what_the_module_has():
    tree = ast.parse(STUB.read_text())
    stub = {}
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            names = [n.name for n in node.body if isinstance(n, ast.FunctionDef)]
            names += [n.target.id for n in node.body if isinstance(n, ast.AnnAssign)]
            stub[node.name] = {name for name in names if not name.startswith("__")}
        elif isinstance(node, ast.FunctionDef):
            stub[node.name] = None
        elif isinstance(node, ast.AnnAssign):
            stub[node.target.id] = None
    public = {name for name in stub if not name.startswith("_") or name == "__version__"}
    assert public == set(dsslam.__all__)
    for name, members in stub.items():
        if members is not None and not name.startswith("_") and name != "Error":
            found = {member for member in dir(getattr(dsslam, name)) if not member.startswith("__")}
            assert members == found, name


def test_doctests():
    results = doctest.testmod(dsslam, optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    assert results.attempted > 8 and results.failed == 0


def test_the_code_of_the_pages_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for page in ["README.md", "docs/python.md", "crates/python/README.md"]:
        blocks = re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(), re.S)
        assert blocks, f"{page} has no Python"
        names = {}
        for block in blocks:
            exec(compile(block, page, "exec"), names)


def test_a_folder_becomes_a_plot(tmp_path):
    folder = tmp_path / "town"
    assert subprocess.run(
        [sys.executable, "-c", f"import sys, dsslam; sys.argv = ['', 'synth', {str(folder)!r}, '--frames', '10']; sys.exit(dsslam.main())"],
        capture_output=True,
    ).returncode == 0
    said = example("01_folder_to_plot.py", folder, "plot.png", cwd=tmp_path)
    assert "Finished(10 of 10 frames" in said and (tmp_path / "plot.png").stat().st_size > 5000


def test_a_capture_is_tracked(tmp_path, frames, world):
    import cv2

    width, height = world.camera.size
    video = cv2.VideoWriter(str(tmp_path / "drive.avi"), cv2.VideoWriter_fourcc(*"MJPG"), 10, (width, height))
    for _, left, _ in frames:
        video.write(np.repeat(left[..., None], 3, axis=2))
    video.release()
    said = example("02_capture_loop.py", "drive.avi", 718.9, 718.9, 607.2, 185.2, cwd=tmp_path)
    assert f"of {len(frames)} frames" in said and "11: " in said
    assert (tmp_path / "capture.tum.txt").is_file()


def test_a_map_becomes_a_colmap_model(tmp_path, frames, world):
    slam = dsslam.Slam(camera=world.camera, settings={"features.selection": "response", "features.keep": 500})
    for frame in frames:
        slam.track(*frame)
    slam.save(tmp_path / "town.dsmap")
    width, height = world.camera.size
    said = example("03_map_to_colmap.py", "town.dsmap", 718.9, 718.9, 607.2, 185.2, width, height, "model", cwd=tmp_path)
    assert "each point is seen" in said
    town = slam.finish().map
    points = (tmp_path / "model/points3D.txt").read_text().splitlines()
    images = (tmp_path / "model/images.txt").read_text().splitlines()
    assert len(points) == town.n_points and len(images) == 2 * town.n_keyframes
    # Each entry of a track is an observation of that point in that image.
    for line in points[:50]:
        cells = line.split()
        for image, place in zip(cells[8::2], cells[9::2]):
            entries = images[2 * int(image) - 1].split()
            assert entries[3 * int(place) + 2] == cells[0]
