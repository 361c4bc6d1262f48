"""Records chosen episodes, a file each."""

from collections import deque
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, SupportsFloat

from asddpg.episodes.loop import count_step
from asddpg.episodes.protocols import Episode, Observation, Step
from asddpg.recording.files.recording_file import RecordingFile, pack_config
from asddpg.recording.messages.channels import Channels
from asddpg.recording.messages.publisher import Publisher
from asddpg.recording.messages.scan_pose_messages import PoseEncoder
from asddpg.recording.messages.scene_messages import scene_message
from asddpg.recording.messages.step_message import encode_json
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.samples import ReadNavigation, Sample, Sampler
from tasks.gymnasium_api.navigation_env import NavigationEnv

BATCH_STEPS = 12  # written at once: a killed process loses no more


@dataclass(frozen=True)
class Provenance:
    """Origin of a recording.

    Attributes:
        config: the resolved configuration, YAML.
        facts: task, seed, versions, hash of the scene, checkpoint that drove: by name, as text.
    """

    config: str
    facts: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Selection:
    """Which episodes are recorded, and which files are kept.

    Attributes:
        chosen: whether the episode of a number, counted from 1, is recorded.
        outcomes: outcomes to keep; empty keeps all.
        keep: files in the folder at most; the oldest go.
    """

    chosen: Callable[[int], bool]
    outcomes: Collection[str] = ()
    keep: int | None = None


def every_nth(every: int) -> Callable[[int], bool]:
    """The first of every so many episodes; 0 for none."""
    return lambda number: every > 0 and (number - 1) % every == 0


class Recorder:
    """Observes an environment's episodes; a failure to record does not stop them.

    Attributes:
        folder: of the files.
        files: completed and kept.
        last: the last of them.
    """

    def __init__(
        self,
        folder: Path,
        environment: NavigationEnv,
        provenance: Provenance,
        selection: Selection,
        notify: Callable[[str], None],
        first_step: int = 0,
        first_episode: int = 0,
        cameras: Cameras | None = None,
        owns_folder: bool = False,
        read_navigation: ReadNavigation | None = None,
    ) -> None:
        """Record into a folder.

        Args:
            folder: for the files; made with the first one.
            environment: its episodes are recorded.
            provenance: origin of the episodes, for each file.
            selection: which episodes.
            notify: called once, with a sentence, if recording fails.
            first_step: training steps that were made before.
            first_episode: episodes that were driven before.
            cameras: their pictures are recorded too.
            owns_folder: whether the folder was made for this recorder; without files it is deleted at the end.
            read_navigation: map and plan of a driver that plans, which are recorded too.
        """
        self.folder, self._facts, self._selection, self._notify = folder, provenance.facts, selection, notify
        self._config = pack_config(provenance.config)
        is_video = cameras is not None and cameras.is_video
        self._model = environment.physics.model.ptr
        self._channels = Channels(cameras.names if cameras else (), is_video, read_navigation is not None)
        poses = PoseEncoder(environment)
        self._publisher = Publisher(self._channels.log, poses, scene_message(self._model), is_video)
        self._sampler = Sampler(environment, cameras, read_navigation)
        self._kept = deque(sorted(folder.glob("*.mcap")))
        self._file: RecordingFile | None = None
        self._samples: list[Sample] = []  # not yet written
        self._number = -1  # of the last one
        self._stats = Episode()  # up to the last one that was written
        self._info: Mapping[str, Any] = {}  # of that one
        self._steps, self._episodes = first_step, first_episode
        self._next_episode, self._owns_folder = first_episode + 1, owns_folder
        self._has_failed = False
        self.files = 0
        self.last: Path | None = None

    def go_to(self, step: int, episode: int) -> None:
        """Number the next episode, which begins at that step; the numbers since the last one are of other robots."""
        self._steps, self._next_episode = step, episode

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Begin a file, if this episode is chosen, or one that another robot drove since the last."""
        numbers = range(self._episodes + 1, self._next_episode + 1)
        self._episodes, self._next_episode = self._next_episode, self._next_episode + 1
        if any(map(self._selection.chosen, numbers)):
            self._stats, self._info, self._number = Episode(), info, -1
            self._samples = [self._sampler.sample(self._number, None, observation)]
            self._file = self._begin_file(info)

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Take a sample, and write a batch when it is full."""
        if self._file is not None:
            self._number += 1
            self._samples.append(self._sampler.sample(self._number, step, step.next_observation))
            if (self._number + 1) % BATCH_STEPS == 0:
                self._try(self._write_batch)

    def end_episode(self, episode: Episode) -> None:
        """Complete the file."""
        if self._file is not None:
            self._try(lambda: self._complete(episode))

    def close(self) -> None:
        """Complete the file of an episode that was interrupted; a folder without files goes."""
        if self._file is not None:
            self._try(self._publish)
            self.end_episode(self._stats)
        if self._owns_folder:
            with suppress(OSError):
                self.folder.rmdir()

    # Files --------------------------------------------------------------------------------------------------------

    def _begin_file(self, info: Mapping[str, Any]) -> RecordingFile:
        facts = {"step": str(self._steps), "episode": str(self._episodes)}
        # Exact: JSON gives a double back to the last bit.
        facts |= {name: encode_json(list(info[name])).decode() for name in ("start", "goal")}
        if "room" in info:  # another one in each episode
            facts["room"] = str(info["room"])
            self._publisher.change_scene(scene_message(self._model))
        if "variation" in info:
            facts["variation"] = encode_json(dict(info["variation"])).decode()
        name = f"{self._steps:08d}_{self._episodes:05d}"
        metadata = {**self._facts, **facts}
        return RecordingFile(self.folder, name, self._channels.context, metadata, self._config)

    def _write_batch(self) -> None:
        assert self._file is not None
        self._publish()
        self._file.flush()

    def _publish(self) -> None:
        samples, self._samples = self._samples, []
        if samples:
            self._publisher.publish(samples)
        for sample in samples:  # here and not in each step, where the caches hold the simulator and the networks
            if sample.step is not None:
                count_step(self._stats, sample.step, self._info)
                self._info = sample.step.info

    def _complete(self, episode: Episode) -> None:
        assert self._file is not None
        if self._selection.outcomes and episode.outcome not in self._selection.outcomes:
            file, self._file = self._file, None
            file.drop()
            return
        self._publish()
        self._publisher.publish_end(episode)
        self.last = self._file.complete(episode.outcome)
        self._file = None
        self.files += 1
        self._kept.append(self.last)
        while self._selection.keep is not None and len(self._kept) > self._selection.keep:
            self._kept.popleft().unlink(missing_ok=True)

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except OSError as error:
            file, self._file = self._file, None
            if file is not None:
                file.drop()  # a checkpoint may need its disk space
            if not self._has_failed:
                self._notify(
                    f"episode {self._episodes} is not recorded: {self.folder}: {error.strerror}; going on without"
                )
            self._has_failed = True
