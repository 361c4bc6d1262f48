"""A policy as an ONNX graph, with its observation's making inside.

Shapes: N batch, R rays, B beams, S scans; metres, m/s, rad/s, robot frame.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper
from torch import Tensor, nn

from asddpg.algorithm.layers import Convolution, Linear
from asddpg.algorithm.networks import NEAREST, Features, Networks, PolicyHead, SwitchBranch
from asddpg.config import TaskConfig

OPSET, IR_VERSION = 18, 9  # of the end of 2022: what robots have reads them
RANGES, PREVIOUS, VELOCITY, GOAL = "ranges", "previous_scans", "velocity", "goal"
COMMAND, SCANS, SWITCH = "command", "scans", "switch_values"


class _Graph:
    """Nodes and constants of a graph in the making; values go by name."""

    def __init__(self) -> None:
        self.nodes: list[onnx.NodeProto] = []
        self.constants: list[onnx.TensorProto] = []

    def constant(self, value: npt.ArrayLike | Tensor, dtype: npt.DTypeLike = np.float32) -> str:
        """The name of a constant."""
        array = value.detach().cpu().numpy() if isinstance(value, Tensor) else np.asarray(value)
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(array, dtype), f"c{len(self.constants)}"))
        return self.constants[-1].name

    def add(self, operator: str, *inputs: str, name: str = "", **attributes: Any) -> str:
        """Apply an operator; the name of its output."""
        output = name or f"{operator.lower()}{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, list(inputs), [output], **attributes))
        return output


def build_graph(networks: Networks, task: TaskConfig, with_switch: bool = False) -> onnx.ModelProto:
    """The policy π, from a scan in metres to v and ω.

    Inputs, float32: `ranges` (N, R), of the newest scan; `previous_scans` (N, S − 1, B), what the last call gave as
    `scans`, zeros at the beginning of an episode; `velocity` (N, 2), v and ω; `goal` (N, 2), metres ahead and to the
    left. Without stacked scans there is no `previous_scans`.
    Outputs, float32: `command` (N, 2), v and ω; `scans` (N, S − 1, B); with the switch `switch_values` (N, 2), Q(x, σ)
    of policy and controller.

    Args:
        networks: of the policy.
        task: that it was trained on.
        with_switch: whether the graph has the switch too.
    """
    graph, laser, stacked = _Graph(), task.laser, task.num_scans > 1
    scans = _stack_scans(graph, task)
    signal = graph.add("Sub", graph.add("Div", scans, graph.constant(laser.max_range)), graph.constant(0.5))
    rest = graph.add("Concat", VELOCITY, _clip_goal(graph, task.goal_range), axis=1)
    policy_features = networks.features if networks.policy_features is None else networks.policy_features
    _add_policy(graph, networks.policy_head, _add_features(graph, policy_features, signal, rest))
    if with_switch:
        assert networks.switch is not None
        _add_switch(graph, networks.switch, _add_features(graph, networks.features, signal, rest))
    kept = [(PREVIOUS, [task.num_scans - 1, laser.num_beams])] if stacked else []
    inputs = [(RANGES, [laser.num_beams * laser.rays_per_beam]), *kept, (VELOCITY, [2]), (GOAL, [2])]
    outputs = [(COMMAND, [2]), *([(SCANS, kept[0][1])] if stacked else []), *([(SWITCH, [2])] if with_switch else [])]
    described = helper.make_graph(
        graph.nodes, "policy", [_describe(*each) for each in inputs], [_describe(*each) for each in outputs],
        graph.constants,
    )  # fmt: skip
    opset = helper.make_opsetid("", OPSET)
    model = helper.make_model(described, opset_imports=[opset], ir_version=IR_VERSION, producer_name="asddpg")
    onnx.checker.check_model(model, full_check=True)
    return model


def _describe(name: str, shape: Sequence[int]) -> onnx.ValueInfoProto:
    return helper.make_tensor_value_info(name, TensorProto.FLOAT, ["N", *shape])


def _stack_scans(graph: _Graph, task: TaskConfig) -> str:
    """[N, S, B] metres, newest first; zeros mark a missing previous scan, and the newest stands for it."""
    laser, last = task.laser, task.num_scans - 1
    clipped = graph.add("Clip", RANGES, graph.constant(laser.min_range), graph.constant(laser.max_range))
    newest = graph.add("Reshape", clipped, graph.constant([-1, 1, laser.num_beams, laser.rays_per_beam], np.int64))
    newest = graph.add("ReduceMin", newest, graph.constant([3], np.int64), keepdims=0)
    if not last:
        return newest
    is_missing = graph.add("LessOrEqual", PREVIOUS, graph.constant(0.0))
    older = graph.add("Where", is_missing, newest, PREVIOUS)
    scans = graph.add("Concat", newest, older, axis=1)
    bounds = (graph.constant([each], np.int64) for each in (0, last, 1))
    graph.add("Slice", scans, *bounds, name=SCANS)
    return scans


def _clip_goal(graph: _Graph, goal_range: float) -> str:
    """tasks.navigation.clip_goal."""
    if math.isinf(goal_range):
        return GOAL
    squares = graph.add("ReduceSumSquare", GOAL, graph.constant([1], np.int64), keepdims=1)
    distance = graph.add("Max", graph.add("Sqrt", squares), graph.constant(1e-9))
    share = graph.add("Min", graph.add("Div", graph.constant(goal_range), distance), graph.constant(1.0))
    return graph.add("Mul", GOAL, share)


def _add_features(graph: _Graph, features: Features, signal: str, rest: str) -> str:
    """[N, F] from the scans, [N, S, B], and the rest of the observation, [N, 4]."""
    if features.scan_shape is None:
        return graph.add("Concat", graph.add("Flatten", signal), rest, axis=1)
    if features.log_ranges:
        share = graph.add("Add", signal, graph.constant(0.5 + NEAREST))
        logarithm = graph.add("Log", graph.add("Max", share, graph.constant(NEAREST)))
        scaled = graph.add("Mul", logarithm, graph.constant(-2.0 / math.log(NEAREST)))
        signal = graph.add("Add", scaled, graph.constant(1.0))
    extracted = _add_layers(graph, features.convolutions, signal)
    beside = graph.add("Flatten", graph.add("Transpose", extracted, perm=[0, 2, 1]))  # as ours, the channels last
    return graph.add("Concat", beside, rest, axis=1)


def _add_layers(graph: _Graph, layers: nn.Sequential, value: str) -> str:
    for layer in layers:
        if isinstance(layer, nn.ReLU):
            value = graph.add("Relu", value)
        elif isinstance(layer, Convolution):
            weight = layer.weight.view(layer.kernel, -1, layer.weight.shape[1]).permute(2, 1, 0)
            value = graph.add("Conv", value, graph.constant(weight), graph.constant(layer.bias), strides=[layer.stride])
        else:
            assert isinstance(layer, Linear)
            value = _add_linear(graph, layer, value)
    return value


def _add_linear(graph: _Graph, layer: Linear, value: str) -> str:
    return graph.add("Gemm", value, graph.constant(layer.weight), graph.constant(layer.bias))


def _add_policy(graph: _Graph, head: PolicyHead, features: str) -> None:
    outputs = _add_linear(graph, head.out, _add_layers(graph, head.hidden, features))
    squashed = graph.add("Tanh", graph.add("Mul", outputs, graph.constant(head.steepness)))
    scaled = graph.add("Mul", squashed, graph.constant(head.half_range))
    graph.add("Add", scaled, graph.constant(head.middle), name=COMMAND)


def _add_switch(graph: _Graph, switch: SwitchBranch, features: str) -> None:
    """Q(x, σ) = V + A − mean A."""
    outputs = _add_linear(graph, switch.out, _add_layers(graph, switch.hidden, features))
    lengths = graph.constant([1, 2], np.int64)
    value, advantage = f"{outputs}_value", f"{outputs}_advantage"
    graph.nodes.append(helper.make_node("Split", [outputs, lengths], [value, advantage], axis=1))
    mean = graph.add("ReduceMean", advantage, graph.constant([1], np.int64), keepdims=1)
    graph.add("Sub", graph.add("Add", value, advantage), mean, name=SWITCH)
