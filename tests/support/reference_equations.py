"""The equations of the paper once more, in NumPy float64 and from nothing else: what losses.py is held against."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

F64 = npt.NDArray[np.float64]
Weights = Mapping[str, F64]


def relu(values: F64) -> F64:
    return np.maximum(values, 0.0)


def linear(weights: Weights, name: str, values: F64) -> F64:
    return values @ weights[f"{name}.weight"] + weights[f"{name}.bias"]


def convolution(weights: Weights, name: str, values: F64, width: int, stride: int) -> F64:
    """[B, L, C] → [B, L', K], valid, cross-correlation."""
    bias = weights[f"{name}.bias"]
    kernel = weights[f"{name}.weight"].reshape(width, values.shape[2], len(bias))
    starts = range(0, values.shape[1] - width + 1, stride)
    return np.stack([np.einsum("bwc,wck->bk", values[:, s : s + width], kernel) + bias for s in starts], axis=1)


def features(weights: Weights, prefix: str, x: F64, scan_shape: tuple[int, int]) -> F64:
    scans, beams = scan_shape
    hidden = x[:, : scans * beams].reshape(-1, scans, beams).transpose(0, 2, 1)
    hidden = relu(convolution(weights, f"{prefix}.convolutions.0", hidden, 5, 2))
    hidden = relu(convolution(weights, f"{prefix}.convolutions.2", hidden, 3, 2))
    return np.concatenate([hidden.reshape(len(x), -1), x[:, scans * beams :]], axis=1)


def layers(weights: Weights, prefix: str, values: F64) -> F64:
    index = 0
    while f"{prefix}.{index}.weight" in weights:
        values = relu(linear(weights, f"{prefix}.{index}", values))
        index += 2
    return values


class Reference:
    """π, Q^A, V and Q(x, σ) of a set of weights."""

    def __init__(self, weights: Weights, scan_shape: tuple[int, int], low: F64, high: F64) -> None:
        self.weights, self.scan_shape, self.low, self.high = weights, scan_shape, low, high

    def policy(self, x: F64) -> F64:
        w = self.weights
        hidden = layers(w, "policy_head.hidden", features(w, "policy_features", x, self.scan_shape))
        z = linear(w, "policy_head.out", hidden)
        sigmoid = self.low + (self.high - self.low) / (1.0 + np.exp(-z))
        tanh = (self.high + self.low) / 2 + (self.high - self.low) / 2 * np.tanh(z)
        return np.where(self.low == 0.0, sigmoid, tanh)

    def q_a(self, x: F64, a: F64) -> F64:
        w = self.weights
        scaled = (a - (self.high + self.low) / 2) / ((self.high - self.low) / 2)
        first = layers(w, "critic.first", features(w, "features", x, self.scan_shape))
        return linear(w, "critic.out", layers(w, "critic.rest", np.concatenate([first, scaled], axis=1)))[:, 0]

    def v_and_q(self, x: F64) -> tuple[F64, F64]:
        w = self.weights
        hidden = layers(w, "switch.hidden", features(w, "features", x, self.scan_shape))
        value, advantage = np.split(linear(w, "switch.out", hidden), [1], axis=1)
        return value[:, 0], value + advantage - advantage.mean(axis=1, keepdims=True)
