"""Play: `python -m asddpg.play run=<run_dir> episodes=3`, recorded for Foxglove.

live=true shows them in Foxglove as they happen; video=out.mp4 makes a film of them.

A policy that the project brings along is run=pretrained:nav_complex. A baseline needs no run:
`python -m asddpg.play agent=controller task=nav_complex`.
"""

import itertools
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from omegaconf import OmegaConf

from asddpg.build import make_cameras, make_live, navigation_env
from asddpg.command_line import option_names, play_config
from asddpg.config import PlayConfig
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Episode, Observer
from asddpg.episodes.steering import SteeredDriver
from asddpg.policy_setup import Driving, open_driving
from asddpg.program import run
from asddpg.recording.how_to_open import how_to_open, how_to_watch
from asddpg.recording.pictures.film import Film
from asddpg.recording.recorder import Recorder
from asddpg.runs.run_folder import unused_folder
from tasks.gymnasium_adapter import NavigationEnv

EPISODES = 3  # where nothing is said


def main(arguments: Sequence[str]) -> None:
    """Compose, drive, print a line an episode."""
    config = play_config(arguments)
    seed = int(np.random.SeedSequence().generate_state(1)[0]) if config.seed is None else config.seed
    driving = open_driving(config, "play", seed)
    environment = navigation_env(driving.environment)
    driver = SteeredDriver(environment, driving.drivers, driving.name)
    folder = unused_folder(driving.evaluation.parent / "played_episodes")
    with ExitStack() as closing:
        cameras = make_cameras(config.record, environment)
        recorder = driving.recorder(config.record, folder, f"drawn, seed {seed}", print, cameras)
        live = make_live(config, environment, cameras, driver) if config.live else None
        if live is not None:
            closing.callback(live.close)
        film = _film(config, driving, environment)
        if film is not None:
            closing.callback(film.close)
        closing.callback(recorder.close)
        # The live view, which waits, comes last.
        observers: list[Observer] = [observer for observer in (recorder, film, live) if observer is not None]
        print(f"{driving.what}, {driving.config.task.name}, seed={seed}")
        if live is not None:
            print(f"{how_to_watch(live.port)}\nwaiting for a viewer; Ctrl-C ends", flush=True)
        closing.callback(lambda: _say_what_there_is(config, recorder, folder))
        _play(config, driving, driver, observers, recorder, seed)


def _film(config: PlayConfig, driving: Driving, environment: NavigationEnv) -> Film | None:
    if config.video is None:
        return None
    timestep = driving.config.task.control_timestep
    return Film(Path(config.video), environment, config.camera, control_timestep=timestep)


def _say_what_there_is(config: PlayConfig, recorder: Recorder, folder: Path) -> None:
    if config.video is not None:
        print(f"the film is {config.video}")
    recorder.close()
    if recorder.files:
        print(how_to_open(recorder.files, folder))


def _play(
    config: PlayConfig,
    driving: Driving,
    driver: SteeredDriver,
    observers: Sequence[Observer],
    recorder: Recorder,
    seed: int,
) -> None:
    driving.environment.reset(seed=seed)
    count = config.episodes or (None if config.live else EPISODES)
    for number in itertools.count(1) if count is None else range(1, count + 1):
        files = recorder.files
        episode = run_episode(driving.environment, driver, observers)
        recorded = f", {recorder.last}" if recorder.files > files else ""
        print(f"episode {number}: {_in_words(episode)}{recorded}", flush=True)


def _in_words(episode: Episode) -> str:
    share = f"controller {100 * episode.controller_share:.0f} %"
    return f"{episode.outcome} after {episode.steps} steps, return {episode.total_reward:.2f}, {share}"


if __name__ == "__main__":
    run(main, f"{__doc__}\n\nOptions: {', '.join(option_names(OmegaConf.structured(PlayConfig)))}")
