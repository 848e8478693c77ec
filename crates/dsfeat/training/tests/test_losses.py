"""Known values of the losses."""

import math

import torch

from dsfeat import losses
from dsfeat.motion import IGNORED, MOVED, STANDING, STILL


def test_semantic_loss_of_a_known_map():
    logits = torch.tensor([[[[0.0, 2.0], [-1.0, 5.0]]]])
    maps = torch.tensor([[[1, 1], [0, 2]]])
    expected = (math.log(2) + math.log1p(math.exp(-2.0)) + 3.0 * math.log1p(math.exp(-1.0))) / 5.0
    assert abs(float(losses.semantic(logits, maps, 3.0)) - expected) < 1e-6


def test_semantic_loss_ignores_unlabelled_pixels():
    maps = torch.tensor([[[2, 0]]])
    one = losses.semantic(torch.tensor([[[[9.0, 1.0]]]]), maps, 1.0)
    two = losses.semantic(torch.tensor([[[[-9.0, 1.0]]]]), maps, 1.0)
    assert torch.equal(one, two)


def test_weights_have_mean_one_and_scale_does_not_matter():
    weights = torch.rand(2, 1, 4, 6) + 0.1
    found = losses.normalised(weights)
    assert torch.allclose(found.mean(dim=(1, 2, 3)), torch.ones(2))
    assert torch.allclose(found, losses.normalised(0.25 * weights))


def test_dense_distance_of_equal_images_is_zero_and_ignores_the_scale_of_the_activation():
    activation, descriptors = torch.rand(1, 1, 8, 8) + 0.1, torch.rand(1, 5, 4, 4)
    assert float(losses.dense_distance(activation, descriptors, 0.5 * activation, descriptors)) < 1e-5


def test_dense_distance_can_be_lowered_by_hiding_what_differs():
    one, two = torch.zeros(1, 2, 1, 2), torch.zeros(1, 2, 1, 2)
    one[0, 0], two[0, 0] = 1.0, 1.0
    one[0, :, 0, 1] = torch.tensor([0.0, 1.0])
    even, hidden = torch.ones(1, 1, 1, 2), torch.tensor([[[[1.0, 0.05]]]])
    assert losses.dense_distance(hidden, one, hidden, two) < losses.dense_distance(even, one, even, two)


def test_points_are_sampled_where_they_lie():
    maps = torch.arange(8.0).reshape(1, 1, 2, 4)
    centre_of_column_2_row_1 = torch.tensor([[[2 * 2.5 / 4 - 1, 2 * 1.5 / 2 - 1]]])
    assert float(losses.at_points(maps, centre_of_column_2_row_1)) == 6.0


def sparse(activation: torch.Tensor, errors: list[float], valid: list[bool]) -> torch.Tensor:
    points = torch.tensor([[[-0.5, 0.0], [0.5, 0.0]]])
    return losses.sparse_distance(activation, points, activation, points, torch.tensor([errors]), torch.tensor([valid]))


def test_sparse_distance_is_the_mean_error_under_equal_activation_of_any_size():
    for value in (1.0, 0.1):
        assert abs(float(sparse(torch.full((1, 1, 1, 2), value), [0.2, 0.6], [True, True])) - 0.4) < 1e-6


def test_sparse_distance_falls_with_the_activation_of_wrong_matches():
    activation = torch.tensor([[[[0.9, 0.1]]]], requires_grad=True)
    distance = sparse(activation, [0.0, 1.0], [True, True])
    assert float(distance) < 0.5
    distance.sum().backward()
    good, bad = activation.grad[0, 0, 0]
    assert good < 0 < bad


def test_sparse_distance_without_matches_is_largest():
    assert float(sparse(torch.ones(1, 1, 1, 2), [0.0, 0.0], [False, False])) == 1.0


def test_triplet_loss():
    positive, negative = torch.tensor([0.1, 0.5]), torch.tensor([0.9, 0.4])
    assert abs(float(losses.triplet(positive, negative, 0.3)) - 0.2) < 1e-6


def test_hybrid_loss_moves_from_semantic_to_matching():
    one, two = torch.tensor(1.0), torch.tensor(3.0)
    weights = [losses.semantic_weight(epoch, 0.9, 0.25) for epoch in (0, 2, 30)]
    assert weights[0] == 1.0 and abs(weights[1] - 0.81) < 1e-12 and weights[2] == 0.25
    assert abs(float(losses.hybrid(one, two, weights[1])) - (0.81 + 0.19 * 3.0)) < 1e-6


def test_motion_loss_weighs_moved_and_standing_pixels():
    logits = torch.tensor([[[[0.0, 2.0, -1.0, 7.0]]]])
    maps = torch.tensor([[[MOVED, STILL, STANDING, IGNORED]]])
    expected = 4.0 * math.log(2) + math.log1p(math.exp(-2.0)) + 3.0 * math.log1p(math.exp(1.0))
    assert abs(float(losses.motion(logits, maps, 4.0, 3.0)) - expected / 8.0) < 1e-6
