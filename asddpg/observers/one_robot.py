"""Shows one robot of a training to observers of single episodes."""

from collections.abc import Callable

from asddpg.episodes.batch_steps import Float32Array, Infos, IntArray, Steps, info_of
from asddpg.episodes.protocols import Episode, Observer
from asddpg.episodes.training_episodes import Learned, TrainingObserver


class OneRobot(TrainingObserver):
    """Notifies an observer of robot 0."""

    def __init__(self, observer: Observer, step: int, go_to: Callable[[int, int], None] | None = None) -> None:
        """Notify from a training step on; `go_to` is called with step and number of each episode before it begins."""
        self._observer, self._step, self._go_to = observer, step, go_to

    def begin_episodes(self, robots: IntArray, numbers: IntArray, observations: Float32Array, infos: Infos) -> None:
        """Notify if robot 0 is among them; it is the first one then."""
        if robots[0] == 0:
            if self._go_to is not None:
                self._go_to(self._step, int(numbers[0]))
            self._observer.begin_episode(observations[0], info_of(infos, 0))

    def step(self, steps: Steps, learned: Learned) -> None:
        """Notify of robot 0's step, with the metrics of the last update."""
        self._step += len(steps.rewards)
        self._observer.step(steps.row(0), learned[-1] if learned else {})

    def end_episode(self, robot: int, number: int, episode: Episode) -> None:
        """Notify if it is robot 0's."""
        if robot == 0:
            self._observer.end_episode(episode)
