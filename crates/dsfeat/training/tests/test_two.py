"""The network with two answers: shapes, what the answers mean, codes of frames, views, a step's determinism, export."""

import json

import cv2
import numpy as np
import onnx
import pytest
import torch

from dsfeat import evaluate, mixed, points, streets, train_two, two_evaluate, two_export, views
from dsfeat.streets import IGNORED, MOVING, STANDING, STILL, VEHICLE, Frames
from dsfeat.teachers import tiles
from dsfeat.two_answers import PIXELS, Logits, TwoAnswers, places, size_for


def frames(name: str = "noise") -> Frames:
    rng = np.random.default_rng(1)
    images = rng.integers(0, 256, (4, 64, 200), dtype=np.uint8)
    codes = rng.integers(0, 5, images.shape, dtype=np.uint8)
    return Frames(name, images, codes, np.array(["a", "a", "b", "c"]), 200 / 64)


def config(**values) -> train_two.Config:
    return train_two.Config(sizes=[[32, 96, 1.0]], groups=[{"count": 2, "sets": {"noise": 1.0}}], **values)


def test_the_answers_have_half_the_size_and_fade_where_the_scene_is_unknown():
    network = TwoAnswers().eval()
    for size in (size_for(aspect, pixels) for aspect in (0.5, 4 / 3, 3.3) for pixels in PIXELS.values()):
        logits = network(torch.rand(1, 1, *size))
        activation, lasting, known = logits.answers()
        assert activation.shape == lasting.shape == (1, 1, size[0] // 2, size[1] // 2) and known.shape == (1, 1, 1, 1)
        assert bool((activation >= lasting).all()), "what moves is a part of what does not last"
    faded = Logits(logits.dynamic, logits.moves, torch.full((1, 1, 1, 1), -30.0)).answers()
    assert all(bool((map > 1 - 1e-6).all()) for map in faded[:2])


def test_the_input_has_the_proportions_of_the_image():
    assert size_for(1241 / 376) == (128, 416) and size_for(1241 / 376, PIXELS["small"]) == (96, 320)
    for aspect in np.linspace(0.5, 4, 30):
        rows, columns = size_for(aspect)
        assert rows % 16 == 0 and columns % 16 == 0 and abs(rows * columns / PIXELS["large"] - 1) < 0.1
        assert 0.85 < columns / rows / aspect < 1.18, aspect


def test_places_of_a_window_are_those_of_the_frame():
    whole = places(torch.tensor([[0.0, 0.0, 1.0, 1.0]]), 4, 8)
    right = places(torch.tensor([[0.5, 0.5, 0.5, 0.5]]), 2, 4)
    assert torch.allclose(whole[:, :, 2:, 4:], right)


def test_places_without_a_window_are_those_of_the_whole_frame():
    assert torch.equal(places(None, 5, 7), places(torch.tensor([[0.0, 0.0, 1.0, 1.0]]), 5, 7))


def test_teachers_tiles_cover_the_frame():
    for size, count in (((1242, 375), 4), ((427, 240), 2), ((300, 300), 1)):
        found = tiles(*size)
        assert len(found) == count and found[0][0] == 0 and found[-1][1] == size[0]
        assert all(b[0] <= a[1] for a, b in zip(found, found[1:]))


def test_motion_labels_give_teachers_regions_their_state():
    codes = np.full((8, 12), STILL, np.uint8)
    codes[2:4, 1:5], codes[2:4, 7:11] = VEHICLE, VEHICLE
    motion = np.full(codes.shape, streets.LABEL_STATIC, np.uint8)
    motion[2:4, 1:4], motion[2:4, 4], motion[6, 6] = streets.LABEL_MOVING, streets.UNKNOWN, streets.LABEL_STANDING
    motion[2:4, 7:9] = streets.UNKNOWN
    found = streets.with_motion(codes, motion)
    assert (found[2:4, 1:5] == MOVING).all(), "the region follows what is known of most of it"
    assert (found[2:4, 7:9] == VEHICLE).all(), "nobody knows whether this one moves"
    assert (found[2:4, 9:11] == IGNORED).all() and found[6, 6] == IGNORED, "one against the other"
    assert found[0, 0] == STILL


def test_states_by_points():
    codes = np.full((10, 10), STILL, np.uint8)
    codes[:3, :3], codes[6:, 6:] = VEHICLE, VEHICLE
    found = streets.with_states(codes, [(0.1, 0.1, "s"), (0.9, 0.9, "m"), (0.5, 0.1, "m")])
    assert found[1, 1] == STANDING and found[8, 8] == MOVING and found[1, 5] == STILL


def test_drives_of_clips():
    assert streets.drive_of("Seq009_Clip01_004") == "Seq009" and streets.drive_of("kitti03_000002_cam2") == "kitti03"
    assert streets.drive_of("car-shadow_00004") == "car-shadow" and streets.drive_of("p268_000006") == "p268"
    every = [d for third in streets.THIRDS for d in third]
    assert len(every) == len(set(every))


def test_a_view_shows_image_and_codes_alike():
    codes = np.zeros((60, 120), np.uint8)
    codes[20:40, 30:90] = MOVING
    rng = np.random.default_rng(3)
    for _ in range(10):
        found = views.view(rng, (codes * 80).astype(np.uint8), codes, 2.0, (64, 128), 0.6, True)
        assert found.image.shape == (64, 128) and found.codes.shape == (32, 64)
        bright = found.image[::2, ::2] > 0.5 * (found.image.min() + found.image.max())
        if (found.codes == MOVING).any() and found.image.std() > 0.1:
            assert (bright == (found.codes == MOVING)).mean() > 0.8


def stepped(tmp_path, key: int) -> dict[str, torch.Tensor]:
    """Weights after one step."""
    streets.save(frames(), tmp_path)
    settings = config(hybrid=True)
    groups = [train_two.Group(g["count"], g["sets"], 0.5, [], tmp_path) for g in settings.groups]
    torch.manual_seed(1)
    network = TwoAnswers()
    optimizer = train_two.optimizer_of(network, settings)
    train_two.step_losses(network, groups, None, settings, 3, key)[0].backward()
    optimizer.step()
    return network.state_dict()


def test_a_step_depends_on_its_number_only(tmp_path):
    one, two, other = stepped(tmp_path, 1), stepped(tmp_path, 1), stepped(tmp_path, 2)
    assert all(torch.equal(one[k], two[k]) for k in one)
    assert not all(torch.equal(one[k], other[k]) for k in one)


def test_drives_left_out_are_not_drawn(tmp_path):
    streets.save(frames(), tmp_path)
    group = train_two.Group(2, {"noise": 1.0}, 0.5, ["a", "b"], tmp_path)
    assert [len(d) for d in group.sets[0][1]] == [1]


def test_the_export_gives_pytorchs_answers(tmp_path):
    torch.manual_seed(2)
    network = TwoAnswers().eval()
    two_export.export_onnx(network, tmp_path / "two.onnx")
    for aspect in (3.3, 1.5):
        assert two_export.compare(network, tmp_path / "two.onnx", size_for(aspect, PIXELS["small"])) < 1e-4
    graph = onnx.load(str(tmp_path / "two.onnx")).graph
    constants = {n.output[0]: n.attribute[0].t for n in graph.node if n.op_type == "Constant"} | {i.name: i for i in graph.initializer}
    neutral = {"Mul": 1.0, "Div": 1.0, "Add": 0.0, "Sub": 0.0}
    for node in graph.node:
        for name in set(node.input) & set(constants) if node.op_type in neutral else ():
            values = onnx.numpy_helper.to_array(constants[name])
            assert (values != neutral[node.op_type]).any(), f"{node.name}: an engine may drop it, though it raises the rank"


def test_unknown_settings_are_refused(tmp_path):
    (tmp_path / "c.json").write_text('{"rat": 1}')
    with pytest.raises(SystemExit, match="unknown keys rat"):
        train_two.read(tmp_path / "c.json")


def test_two_wheelers_move_with_a_rider_and_stand_alone():
    labels = np.zeros((30, 40), np.uint8)
    labels[10:14, 2:6], labels[6:9, 3:5] = 18, 12
    labels[10:14, 15:19] = 18
    labels[10:14, 28:32], labels[8:14, 33:35] = 17, 11
    labels[22:28, 10:20] = 13
    codes = streets.class_codes(labels, "cityscapes256")
    assert (codes[10:14, 2:6] == MOVING).all() and (codes[10:14, 15:19] == STANDING).all()
    assert (codes[10:14, 28:32] == VEHICLE).all(), "somebody walks beside it"
    assert codes[24, 12] == VEHICLE and codes[0, 0] == STILL


def test_seams_take_the_nearest_label_and_threads_none():
    codes = np.full((20, 30), STILL, np.uint8)
    codes[5:15, 5:15], codes[4:16, 4], codes[4:16, 15:17] = VEHICLE, IGNORED, IGNORED
    codes[18:, :], codes[2, 18:28] = IGNORED, VEHICLE
    found = streets.mended(np.vstack([codes, np.zeros((10, 30), np.uint8)]), "cityscapes256")
    assert (found[5:15, 5:15] == VEHICLE).all() and found[10, 15] == VEHICLE and found[10, 16] == STILL and found[10, 4] in (STILL, VEHICLE)
    assert (found[24:] == IGNORED).all(), "what is far from a label stays without one"
    assert (found[2, 18:28] == IGNORED).all(), "a wire is not a vehicle"


def test_an_exported_model_can_be_loaded_again(tmp_path):
    torch.manual_seed(3)
    network = TwoAnswers()
    network(torch.rand(2, 1, 64, 96))
    network.eval()
    two_export.export_onnx(network, tmp_path / "model.onnx")
    again = train_two.starting(tmp_path / "model.onnx").eval()
    image = torch.rand(1, 1, 64, 96)
    for a, b in zip(network(image).answers(), again(image).answers()):
        assert torch.allclose(a, b, atol=1e-5)


def test_repainting_changes_vehicles_only():
    rng = np.random.default_rng(5)
    image = rng.integers(60, 200, (40, 90), dtype=np.uint8)
    codes = np.full(image.shape, STILL, np.uint8)
    codes[5:20, 5:30], codes[10:30, 50:80] = MOVING, STANDING
    found = views.repainted(rng, image, codes)
    assert np.array_equal(found[codes == STILL], image[codes == STILL])
    for code in (MOVING, STANDING):
        assert np.abs(found[codes == code].astype(int) - image[codes == code]).mean() > 5


def test_traffic_is_every_fourth_frame_of_its_presets_and_the_chosen_seed_only_measures(tmp_path):
    for name in ("jam_101", "trams_102", "jam_71", "busy_204"):
        for part, value in (("image_0", 90), ("masks", 1)):
            (tmp_path / name / part).mkdir(parents=True)
            for i in range(6):
                assert cv2.imwrite(str(tmp_path / name / part / f"{i:06}.png"), np.full((188, 620), value, np.uint8))
    found = {name: streets.traffic(name, tmp_path, 4) for name in ("traffic", "traffic_dev")}
    assert found["traffic"].drives.tolist() == ["jam_101"] * 2 + ["trams_102"] * 2
    assert found["traffic_dev"].drives.tolist() == ["jam_71"] * 2 and (found["traffic"].codes == MOVING).all()


def test_states_count_what_lies_below_one_half():
    images = np.zeros((1, 10, 20), np.uint8)
    codes = np.full(images.shape, STILL, np.uint8)
    codes[:, :, 10:], codes[:, :2, :10] = MOVING, STANDING
    activation = np.where(np.arange(20) < 16, 0.9, 0.1) * np.ones((10, 1))
    predict = (lambda shown: (activation[None], activation[None]), lambda aspect: (10, 20))
    found = two_evaluate.states(predict, [Frames("x", images, codes, np.array(["a"]), 2.0)])
    assert found["moving_below_half"] == pytest.approx(0.4) and found["still_below_half"] == found["standing_below_half"] == 0.0


def test_a_mixture_lies_between_both_networks():
    one, two = TwoAnswers().state_dict(), TwoAnswers().state_dict()
    for share, other in ((0.0, one), (1.0, two)):
        found = mixed.mixture(one, two, share)
        assert all(torch.allclose(found[k], other[k]) for k in one)
    half = mixed.mixture(one, two, 0.5)
    assert torch.allclose(half["head.weight"], 0.5 * (one["head.weight"] + two["head.weight"]))


def test_boxes_tell_what_a_tracked_point_is(tmp_path):
    focal, base, depth = 700.0, 0.5, 10.0
    camera = (focal, 600.0, 180.0, base)
    path = tmp_path / "boxes.txt"
    box = "{} {} Car 0 0 0 500 100 700 300 1.5 1.6 4.0 0.0 1.6 10.0 0.0\n"
    path.write_text(box.format(3, points.MOVERS[0]) + box.format(4, 99) + "5 -1 DontCare -1 -1 -10 500 100 700 300 -1000 -1000 -1000 -10 -1 -1 -1\n")
    row = [("frame", int), ("x", float), ("y", float), ("Z", float), ("du", float), ("dr", float)]

    def label(frame, x, y=200.0, z=depth, du=0.0, dr=0.0):
        return int(points.in_boxes(np.array([(frame, x, y, z, du, dr)], dtype=row), path, camera)[0])

    assert label(3, 600) == streets.LABEL_MOVING and label(4, 600) == streets.LABEL_STANDING
    assert label(3, 600 + focal * 2.1 / depth) == 0, "beside the side of the box"
    assert label(3, 900) == label(3, 600, z=40.0) == label(6, 600) == streets.LABEL_STATIC
    assert label(5, 600) == 0, "nobody has boxes here"
    # The frame's own disparity places the feature, not the map's point, which may have been left behind.
    assert label(3, 600, z=14.0, du=focal * base / depth - focal * base / 14.0) == streets.LABEL_MOVING
    assert label(3, 600, dr=np.nan) == 0


def test_a_measure_without_pixels_is_null_in_the_figures():
    some = frames()
    some.codes[:] = STILL
    predict = (lambda shown: (np.full((len(shown), 32, 100), 0.75),) * 2, lambda aspect: (64, 200))
    found = {"some": two_evaluate.states(predict, [some]), "classes": two_evaluate.classes(predict, some)}
    written = json.loads(json.dumps(evaluate.rounded(found), allow_nan=False))
    assert written["some"]["auc_still_moving"] is None and written["classes"]["auc"] is None
    assert written["some"]["mean_still"] == pytest.approx(0.75, abs=1e-3)
