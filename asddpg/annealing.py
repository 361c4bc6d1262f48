"""How Adam's steps shrink towards the end of training, so that the last weights are no matter of the moment."""


class Annealing:
    """Scale of the learning rates: 1, then linearly to 0 over the last part of training."""

    def __init__(self, share: float, total_steps: int) -> None:
        """Shrink over the last `share` (0 to 1; 0 for never) of `total_steps` steps of training."""
        self._share, self._total_steps = share, total_steps

    def scale(self, step: int) -> float:
        """Scale at a step of training, 0 to 1."""
        if not self._share:
            return 1.0
        left = max(0.0, 1.0 - step / self._total_steps)
        return min(1.0, left / self._share)
