"""Writes the tiny models of the tests: python3 make_models.py (needs the package onnx)."""
from onnx import TensorProto, checker, helper, save


def model(name, nodes, inputs, outputs):
    make = lambda n, s: helper.make_tensor_value_info(n, TensorProto.FLOAT, s)
    graph = helper.make_graph(nodes, name, [make(*i) for i in inputs], [make(*o) for o in outputs])
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    checker.check_model(made)
    save(made, f"{name}.onnx")


pool = lambda i, o, k: helper.make_node("AveragePool", [i], [o], kernel_shape=[k, k], strides=[k, k])
image = ("image", [1, 1, 32, 64])
# The mean brightness of squares of 4 x 4 pixels.
model("mean_4", [pool("image", "activation", 4)], [image], [("activation", [1, 1, 8, 16])])
# The same, not a number where the image is black.
divide = helper.make_node("Div", ["mean", "mean"], ["activation"])
model("not_a_number", [pool("image", "mean", 4), divide], [image], [("activation", [1, 1, 8, 16])])
# Colour instead of grey, and a result without rows and columns.
model("colour", [pool("image", "activation", 4)], [("image", [1, 3, 32, 64])], [("activation", [1, 3, 8, 16])])
shape = helper.make_node("Flatten", ["image"], ["activation"])
model("flat", [shape], [image], [("activation", [1, 2048])])
two = helper.make_node("Add", ["image", "other"], ["activation"])
model("two_inputs", [two], [image, ("other", [1, 1, 32, 64])], [("activation", [1, 1, 32, 64])])
# An operator that only ONNX Runtime has.
normalize = helper.make_node("LRN", ["mean"], ["activation"], size=3)
model("normalized", [pool("image", "mean", 4), normalize], [image], [("activation", [1, 1, 8, 16])])
