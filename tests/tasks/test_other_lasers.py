"""Lasers other than the URG-04LX: field of view, beams, ranges and height."""

import copy
import math
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
import pytest

import tasks
from tasks.errors import TaskError
from tasks.gymnasium_api.navigation_env import NavigationEnv
from tasks.gymnasium_api.navigation_vector_env import NavigationVectorEnv
from tasks.laser import BeamRing, LaserConfig, laser_position
from tasks.physics import Physics, Pose
from tasks.registry import task_model
from tasks.scene.loading import load_model, model_hash, open_scene, scene_path

WIDE = {"field_of_view": 270.0, "num_beams": 1081, "max_range": 10.0}
ROUND = {"field_of_view": 360.0, "num_beams": 360, "min_range": 0.12, "max_range": 3.5}
LASERS = [WIDE, ROUND]
START, GOAL = (0.3, -0.4, 1.0), (0.0, 1.0)


def place(physics: Physics, pose: tuple[float, float, float]) -> None:
    with physics.reset_context():
        physics.set_pose(Pose(*pose))


def cast(physics: Physics, ring: BeamRing, height: float) -> npt.NDArray[np.float64]:
    """Ranges by single rays of MuJoCo's, from the place where the laser should be, past the robot."""
    model, data = physics.model.ptr, physics.data.ptr
    base = data.body("base")
    rotation = base.xmat.reshape(3, 3)
    origin = base.xpos + rotation @ [0.1, 0.0, height]
    is_robot = model.body_rootid[model.geom_bodyid] == model.body("base").id
    before = model.geom_rgba.copy(), model.geom_matid.copy()
    model.geom_rgba[is_robot, 3], model.geom_matid[is_robot] = 0.0, -1
    geom, lengths = np.zeros(1, np.int32), []
    for angle in ring.angles():
        along = rotation @ [math.cos(angle), math.sin(angle), 0.0]
        length = mujoco.mj_ray(model, data, origin, along, None, 1, -1, geom)
        lengths.append(length if length >= 0.0 else math.inf)
    model.geom_rgba[:], model.geom_matid[:] = before
    return np.clip(lengths, ring.min_range, ring.max_range)


@pytest.mark.parametrize("name", ["nav_complex", "nav_gazebo", "clutter:3"])
@pytest.mark.parametrize("options", [*LASERS, {**ROUND, "height": 0.5}], ids=str)
def test_beams_are_where_the_options_say(name: str, options: dict[str, Any]) -> None:
    environment = tasks.load(name, random=0, config={"laser": options})
    physics, ring = environment.physics, environment.task.config.laser.ring
    environment.reset()
    observed = environment.step((0.0, 0.0)).observation["ranges"]
    np.testing.assert_allclose(observed, cast(physics, ring, ring.height or 0.287), atol=1e-3)
    bounds = environment.observation_spec()["ranges"]
    assert (bounds.minimum, bounds.maximum) == (ring.min_range, ring.max_range)


def test_a_whole_turn_has_no_beam_twice() -> None:
    angles = BeamRing(360, 360.0).angles()
    turns = np.diff(np.append(angles, angles[0] + 2 * math.pi))
    np.testing.assert_allclose(turns, np.radians(1.0), atol=1e-12)
    assert angles[180] == 0.0
    assert np.degrees(BeamRing(1081, 270.0).angles()[[0, 540, -1]]) == pytest.approx((-135.0, 0.0, 135.0))


def test_ranges_end_at_the_lasers_own_limits() -> None:
    physics = open_scene(scene_path("nav_empty"), ring=BeamRing(max_range=2.0, min_range=0.5))
    place(physics, (3.0, 0.0, 0.0))
    ranges = physics.ranges()
    assert (ranges.min(), ranges.max()) == (pytest.approx(0.9, abs=0.01), 2.0)
    place(physics, (3.6, 0.0, 0.0))
    assert physics.ranges().min() == 0.5


def test_noise_and_dropout_keep_to_the_lasers_own_limits() -> None:
    laser = {**ROUND, "noise": 3.0, "dropout": 0.2}
    environment = tasks.load("nav_complex", random=0, config={"laser": laser})
    clean = tasks.load("nav_complex", random=0, config={"laser": ROUND})
    seen, expected = (each.reset().observation["ranges"] for each in (environment, clean))
    assert 0.12 <= seen.min() < seen.max() == 3.5
    lost = (seen == 3.5) & (expected < 3.3)
    assert 0.1 < lost[expected < 3.3].mean() < 0.3
    np.testing.assert_array_equal(seen[expected == 3.5], 3.5)


@pytest.mark.parametrize("options", LASERS, ids=str)
def test_observations_are_ranges_over_the_lasers_own_greatest(options: dict[str, Any]) -> None:
    environment = NavigationEnv("nav_complex", config={"laser": options}, num_scans=2)
    observation, _ = environment.reset(options={"start": START, "goal": GOAL})
    scan = environment.physics.ranges() / options["max_range"] - 0.5
    np.testing.assert_array_equal(observation[:-4].reshape(2, -1), np.array([scan, scan], np.float32))
    assert environment.observation_space.contains(observation)


@pytest.mark.parametrize("options", [*LASERS, {**ROUND, "noise": 1.0, "latency": 0.3}], ids=str)
def test_robots_of_a_vector_equal_single_ones(options: dict[str, Any]) -> None:
    config = {"laser": options}
    vector, single = NavigationVectorEnv("nav_complex", 2, config=config), NavigationEnv("nav_complex", config=config)
    np.testing.assert_array_equal(vector.reset(seed=5)[0][1], single.reset(seed=6)[0])
    for _ in range(8):
        action = np.array([0.3, 0.4])
        np.testing.assert_array_equal(vector.step(np.stack([action, action]))[0][1], single.step(action)[0])
    vector.close()


def test_a_copy_has_the_same_limits() -> None:
    environment = NavigationEnv("nav_empty", config={"laser": ROUND})
    environment.reset(seed=0)
    for copied in (copy.deepcopy(environment).physics, environment.physics.copy(share_model=True)):
        assert (copied.min_range, copied.max_range) == (0.12, 3.5)
        np.testing.assert_array_equal(copied.ranges(), environment.physics.ranges())


@pytest.mark.parametrize("name", ["nav_complex", "cylinders:3"])
def test_the_default_laser_leaves_the_scene_as_it_is_and_another_changes_its_hash(name: str) -> None:
    plain = model_hash(task_model(name))
    assert model_hash(task_model(name, LaserConfig(noise=1.0).ring)) == plain
    changes: list[dict[str, Any]] = [{"min_range": 0.1}, {"max_range": 10.0}, {"field_of_view": 270.0}, {"height": 0.3}]
    for change in changes:
        assert model_hash(task_model(name, BeamRing()._replace(**change))) != plain


def test_the_laser_stands_where_its_height_says_with_its_housing() -> None:
    plain = load_model(scene_path("nav_empty"))
    model = load_model(scene_path("nav_empty"), BeamRing(height=0.6))
    assert laser_position(model) == pytest.approx((0.1, 0.0, 0.6))
    assert model.body("laser").pos[2] - plain.body("laser").pos[2] == pytest.approx(0.6 - 0.287)


def test_a_laser_within_the_robot_is_refused() -> None:
    with pytest.raises(TaskError, match=r"must lie above the robot, whose laser is at 0.287 m: at 0.15 m 40 of its 40"):
        tasks.load("nav_empty", config={"laser": {"height": 0.15}})


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"field_of_view": 0.0}, "field_of_view must be above 0 and up to 360"),
        ({"field_of_view": 361.0}, "field_of_view must be above 0 and up to 360"),
        ({"field_of_view": math.nan}, "field_of_view must be a finite number"),
        ({"min_range": 5.6}, "min_range must be below max_range, 5.6, not 5.6"),
        ({"max_range": 0.0}, "max_range must be from 0.1 to 100"),
        ({"height": -1.0}, "height must be from 0.02 to 2"),
    ],
)
def test_a_laser_that_cannot_be_is_refused(options: dict[str, Any], sentence: str) -> None:
    with pytest.raises(TaskError, match=sentence):
        LaserConfig(**options)
