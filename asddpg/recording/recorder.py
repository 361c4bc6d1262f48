"""Records chosen episodes, a file each."""

from collections import deque
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, SupportsFloat

from asddpg.episodes.protocols import Episode, Observation, Step
from asddpg.recording.files.journal import Layout
from asddpg.recording.files.mcap_file import RecordingFile, RecordingFiles
from asddpg.recording.messages.channels import Channels
from asddpg.recording.messages.pose_messages import States
from asddpg.recording.messages.publisher import Publisher
from asddpg.recording.messages.scene_messages import scene_message
from asddpg.recording.messages.step_message import as_json, told
from asddpg.recording.pictures.cameras import Cameras
from asddpg.recording.samples import Moment, MomentReader, Reading, Watched
from tasks.scene.frames import BodyFrames

BATCH_STEPS = 10  # brought to the disk at once; a killed process loses no more


@dataclass(frozen=True)
class Provenance:
    """What a recording is of.

    Attributes:
        config: the resolved configuration, YAML.
        facts: task, seed, versions, hash of the scene, which checkpoint drove: by name, as text.
    """

    config: str
    facts: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Selection:
    """Which episodes are recorded, and what is kept of them.

    Attributes:
        chosen: whether the episode of a number, counted from 1, is recorded.
        outcomes: outcomes that are kept; none given, all.
        keep: files in the folder at most; the oldest go.
    """

    chosen: Callable[[int], bool]
    outcomes: Collection[str] = ()
    keep: int | None = None


def every_nth(every: int) -> Callable[[int], bool]:
    """The first of every so many episodes; 0 for none."""
    return lambda number: every > 0 and (number - 1) % every == 0


class Recorder:
    """Watches an environment's episodes; what goes wrong in recording stops nobody."""

    def __init__(
        self,
        folder: Path,
        environment: Watched,
        provenance: Provenance,
        selection: Selection,
        say: Callable[[str], None],
        first_step: int = 0,
        first_episode: int = 0,
        counts_steps: bool = True,
        cameras: Cameras | None = None,
    ) -> None:
        """Record into a folder.

        Args:
            folder: where the files go; made with the first one.
            environment: what is watched.
            provenance: what is recorded, for each file.
            selection: which episodes.
            say: told once if recording fails.
            first_step: training steps that were made before.
            first_episode: episodes that were driven before.
            counts_steps: whether the steps that are watched are training steps too.
            cameras: whose pictures are recorded too.
        """
        self._folder, self._facts, self._selection, self._say = folder, provenance.facts, selection, say
        is_video = cameras is not None and cameras.is_video
        channels = Channels(cameras.names if cameras else (), is_video)
        model, scan_shape = environment.physics.model.ptr, environment.scan_shape
        layout, scene = Layout(BodyFrames.from_model(model), scan_shape, is_video), scene_message(model)
        self._files = RecordingFiles(folder, channels, provenance.config, layout, scene)
        self._kept = deque(sorted(folder.glob("*.mcap")))
        self._reader = MomentReader(environment, cameras)
        self._publisher = Publisher(channels.log, States(layout.frames, scan_shape), scene, is_video)
        self._file: RecordingFile | None = None
        self._readings: list[Reading] = []  # since moments were brought to the disk
        self._moments: list[Moment] = []  # there
        self._steps, self._episodes = first_step, first_episode
        self._counts_steps = counts_steps
        self._has_failed = False
        self.files = 0  # completed and kept
        self.last: Path | None = None  # the last of them

    def begin_episode(self, observation: Observation, info: Mapping[str, Any]) -> None:
        """Open a file, if this episode is chosen."""
        self._episodes += 1
        if self._selection.chosen(self._episodes):
            self._try(lambda: self._open(observation, info))

    def step(self, step: Step, learned: Mapping[str, SupportsFloat]) -> None:
        """Keep what there is to tell, and bring it to the disk when there is enough."""
        self._steps += self._counts_steps
        if self._file is not None:
            reading = self._reader.step(step)
            self._readings.append(reading)
            if (reading.number + 1) % BATCH_STEPS == 0:
                self._try(self._bring)

    def end_episode(self, episode: Episode) -> None:
        """Complete the file."""
        if self._file is not None:
            self._try(lambda: self._finish(episode))

    def close(self) -> None:
        """Complete the file of an episode that was broken off."""
        if self._file is not None:
            self._moments += self._taken()
            self.end_episode(self._publisher.cut(self._moments))

    # Files --------------------------------------------------------------------------------------------------------

    def _open(self, observation: Observation, info: Mapping[str, Any]) -> None:
        facts = {"step": str(self._steps), "episode": str(self._episodes)}
        # Exactly: JSON gives a double back to the last bit.
        facts |= {name: as_json(list(info[name])).decode() for name in ("start", "goal")}
        name = f"{self._steps:08d}_{self._episodes:05d}"
        self._file = RecordingFile(self._files, name, {**self._facts, **facts})
        self._readings, self._moments = [self._reader.begin(observation)], []

    def _bring(self) -> None:
        assert self._file is not None
        moments = self._taken()
        self._file.add(moments)
        self._moments += moments

    def _taken(self) -> list[Moment]:
        """What was read, in words."""
        readings, self._readings = self._readings, []
        return [told(reading) for reading in readings]

    def _finish(self, episode: Episode) -> None:
        assert self._file is not None
        if self._selection.outcomes and episode.outcome not in self._selection.outcomes:
            file, self._file = self._file, None
            file.drop()
            return
        self.last = self._file.finish(episode.outcome, lambda: self._tell(episode))
        self._file = None
        self.files += 1
        self._kept.append(self.last)
        while self._selection.keep is not None and len(self._kept) > self._selection.keep:
            self._kept.popleft().unlink(missing_ok=True)

    def _tell(self, episode: Episode) -> None:
        """The whole episode, to the file that is open."""
        self._publisher.tell(self._moments + self._taken())
        self._publisher.end(episode)

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except OSError as error:
            if self._file is not None:
                self._file.drop()  # what it holds would take the room that a checkpoint needs
                self._file = None
            if not self._has_failed:
                self._say(
                    f"episode {self._episodes} is not recorded: {self._folder}: {error.strerror}; going on without"
                )
            self._has_failed = True
