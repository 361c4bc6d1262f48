"""Play: `python -m asddpg.play run=<run_dir> episodes=3`, recorded for Foxglove.

live=true shows them in Foxglove as they happen; video=out.mp4 makes a film of them.

run=pretrained:nav_complex is a policy that the project ships. A baseline needs no run:
`python -m asddpg.play agent=controller task=nav_complex`.
"""

import itertools
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from asddpg.build import make_cameras, make_live, navigation_env, prepare_torch
from asddpg.command_line import driver_config
from asddpg.config import PlayConfig
from asddpg.drivers.driver_setup import DriverSetup, set_up_driver
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Observer
from asddpg.episodes.steering import SteeredDriver
from asddpg.messages import OUT, print_line
from asddpg.options.help_text import help_text
from asddpg.planning.navigation_view import view_plan
from asddpg.program import run
from asddpg.recording.how_to_open import how_to_open, how_to_watch
from asddpg.recording.pictures.film import Film
from asddpg.recording.recorder import Recorder

EPISODES = 3  # without episodes= and live=true


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Compose, drive, print a line an episode."""
    config = driver_config(PlayConfig, arguments)
    seed = int(np.random.SeedSequence().generate_state(1)[0]) if config.seed is None else config.seed
    setup = set_up_driver(config, "play", seed)
    environment = navigation_env(setup.environment)
    driver = SteeredDriver(environment.set_goal, setup.drivers, setup.name)
    with ExitStack() as closing:
        cameras = make_cameras(config.record, environment)
        read_plan = (lambda: view_plan(driver.current)) if setup.plans else None
        pairs = f"drawn, seed {seed}"
        recorder = setup.recorder(config.record, "played_episodes", pairs, print_line, cameras, read_plan)
        closing.callback(recorder.close)
        live = make_live(config, environment, cameras, driver, read_plan) if config.live else None
        if live is not None:
            closing.callback(live.close)
        film = None
        if config.video is not None:
            timestep = setup.config.task.control_timestep
            film = Film(Path(config.video), environment, config.camera, control_timestep=timestep)
            closing.callback(film.close)
        # The live view, which waits, comes last.
        observers: list[Observer] = [observer for observer in (recorder, film, live) if observer is not None]
        print_line(f"{setup.title}, {setup.config.task.name}, seed={seed}")
        if live is not None:
            print_line(f"{how_to_watch(live.port)}\nwaiting for a viewer; Ctrl-C ends")
        closing.callback(lambda: _print_files(config, recorder, film))
        setup.environment.reset(seed=seed)
        _drive_episodes(config, setup, driver, observers, recorder)


def _print_files(config: PlayConfig, recorder: Recorder, film: Film | None) -> None:
    recorder.close()
    if film is not None:
        film.close()
        print_line(f"the film is {config.video}")
    if recorder.files:
        print_line(how_to_open(recorder.files, recorder.folder))


def _drive_episodes(
    config: PlayConfig, setup: DriverSetup, driver: SteeredDriver, observers: Sequence[Observer], recorder: Recorder
) -> None:
    count = config.episodes or (None if config.live else EPISODES)
    for number in itertools.count(1) if count is None else range(1, count + 1):
        if OUT.is_broken:  # its reader is gone
            return
        files = recorder.files
        episode = run_episode(setup.environment, driver, observers)
        recorded = f", {recorder.last}" if recorder.files > files else ""
        driven = f"{episode.outcome} after {episode.steps} steps, return {episode.total_reward:.2f}"
        room = navigation_env(setup.environment).task.room
        place = f" in {room}" if room else ""
        print_line(f"episode {number}{place}: {driven}, controller {100 * episode.controller_share:.0f} %{recorded}")


if __name__ == "__main__":
    run(main, help_text(__doc__, PlayConfig))
