"""Missions: `python -m asddpg.mission agent=move_base task=nav_office`.

A robot is sent to targets in turn, in a room that holds obstacles its map lacks. It knows its pose by its wheels, its
laser and the map alone. agent=waypoints run=<run_dir> leads a policy along a planner's path, as in the paper's real
room. Each mission leaves a picture and a recording, all of them missions.csv.
"""

import itertools
from collections.abc import Iterable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from asddpg.atomic_write import claim_folder
from asddpg.build import make_cameras, make_live, navigation_env, prepare_torch
from asddpg.command_line import driver_config
from asddpg.config import MissionConfig
from asddpg.drivers.driver_setup import DriverSetup, Setting, set_up_driver
from asddpg.drivers.localized_robot import LocalizedRobot
from asddpg.episodes.loop import run_episode
from asddpg.episodes.protocols import Observer
from asddpg.episodes.steering import SteeredDriver
from asddpg.messages import OUT, print_line
from asddpg.missions.environment import MissionEnvironment
from asddpg.missions.log import MissionLog
from asddpg.missions.picture import draw_mission as draw_picture
from asddpg.missions.report import MissionRow, summarize, write_rows
from asddpg.missions.setting import MissionSetting, draw_mission
from asddpg.options.help_text import help_text
from asddpg.planning.navigation_view import NavigationView, view_plan
from asddpg.program import run
from asddpg.recording.how_to_open import how_to_open, how_to_watch
from asddpg.recording.recorder import Recorder
from tasks.gymnasium_api.navigation_env import NavigationEnv


@prepare_torch()
def main(arguments: Sequence[str]) -> None:
    """Drive the missions, print a line each, write pictures, recordings and missions.csv."""
    config = driver_config(MissionConfig, arguments)
    setting = MissionSetting(config)
    setup = set_up_driver(config, "mission", config.seed, Setting(setting.prepare_task, setting.make_robot))
    environment = navigation_env(setup.environment)
    robot = setting.make_robot(environment)
    missions = MissionEnvironment(environment, robot, config.within, config.patience)
    driver = SteeredDriver(missions.set_goal, setup.drivers, setup.name)
    view = partial(_view, driver, robot)
    with ExitStack() as closing:
        # Wrong places, cameras and a taken port are found before anything is written.
        missions.reset(options={"mission": draw_mission(config, environment, 1)})
        cameras = make_cameras(config.record, environment)
        live = make_live(config, environment, cameras, driver, view) if config.live else None
        if live is not None:
            closing.callback(live.close)
            print_line(f"{how_to_watch(live.port)}\nwaiting for a viewer; Ctrl-C ends")
        setup = replace(setup, out=claim_folder(setup.out / "missions"))
        title = f"missions, seed {config.seed}"
        recorder = setup.recorder(config.record, "episodes", title, print_line, cameras, view)
        lacking = ", ".join(setting.unmapped) or "nothing"
        print_line(f"{setup.title}, {setup.config.task.name}, seed={config.seed}; not on the map: {lacking}")
        observers: list[Observer] = [observer for observer in (recorder, live) if observer is not None]
        rows: list[MissionRow] = []
        closing.callback(lambda: _conclude(rows, setup, recorder))
        for number in _numbers(config):
            log = MissionLog(draw_mission(config, environment, number))
            run_episode(missions, driver, [log, *observers], {"mission": log.mission})
            rows.append(_report(log, number, config, setting, environment, setup.out))
            if OUT.is_broken:  # its reader is gone
                return


def _view(driver: SteeredDriver, robot: LocalizedRobot) -> NavigationView:
    """What the robot knows and intends: its own map, where its driver has none."""
    view = view_plan(driver.current)
    return view._replace(map=view.map or robot.map, particles=robot.amcl.particles, pose=robot.reading.pose)


def _numbers(config: MissionConfig) -> Iterable[int]:
    if config.missions is None and config.live:
        return itertools.count(1)
    return range(1, (config.missions or 1) + 1)


def _report(
    log: MissionLog,
    number: int,
    config: MissionConfig,
    setting: MissionSetting,
    environment: NavigationEnv,
    folder: Path,
) -> MissionRow:
    """Print a mission's line, and draw its picture."""
    failure = log.failure(config.within, setting.unmapped)
    row = MissionRow.of_log(log, number, environment.task.config.control_timestep, failure)
    print_line(row.describe())
    picture = draw_picture(log, environment.obstacles, setting.known, config.within)
    picture.write(folder / f"mission_{number:02d}.png", f"mission {number}: {failure or 'all targets reached'}")
    return row


def _conclude(rows: Sequence[MissionRow], setup: DriverSetup, recorder: Recorder) -> None:
    """Write missions.csv, print the result, also after Ctrl-C."""
    recorder.close()
    if rows:
        write_rows(rows, setup.out / "missions.csv")
        print_line(f"{summarize(rows)}\npictures and missions.csv in {setup.out}")
    if recorder.files:
        print_line(how_to_open(recorder.files, recorder.folder))
    with suppress(OSError):  # nothing was driven: an empty folder goes
        setup.out.rmdir()


if __name__ == "__main__":
    run(main, help_text(__doc__, MissionConfig))
