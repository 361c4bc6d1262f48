"""Properties of the robot against analysis."""

import json
from typing import Any

import mujoco
import numpy as np
import pytest

from tasks import constants
from tasks.room_geometry.geom_shapes import extent
from tasks.scene.loading import load_model, open_scene
from tools import robot_figures
from tools.robot.robot_quantities import RobotQuantities
from tools.robot.scene_argument import PIONEER_SCENE


def measure(scene: str | None = None) -> dict[str, dict[str, Any]]:
    """The values of all quantities, of the project's robot or of a scene, by section and name."""
    model = mujoco.MjModel.from_xml_string(scene) if scene else load_model(PIONEER_SCENE)
    sections = RobotQuantities(model).sections
    return {title: {name: quantity.value for name, quantity in part.items()} for title, part in sections.items()}


def test_mass_and_inertia_are_those_of_the_free_joints_block_of_the_mass_matrix() -> None:
    found = measure()["mass"]
    physics = open_scene(PIONEER_SCENE)  # in its keyframe's pose, which is the reference
    model = physics.model.ptr
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, physics.data.ptr, matrix)
    start = int(model.joint("base").dofadr[0])
    free = matrix[start : start + 6, start : start + 6]
    np.testing.assert_allclose(free[:3, :3], found["total"] * np.eye(3), atol=1e-9)
    centre = np.array(found["centre of mass"])
    inertia = free[3:, 3:] - found["total"] * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    np.testing.assert_allclose(np.diag(inertia), found["inertia"], atol=1e-9)
    np.testing.assert_allclose(inertia[[0, 0, 1], [1, 2, 2]], found["inertia, products"], atol=1e-9)
    assert found["total"] == pytest.approx(9.0 + 0.16)
    assert (centre[0], centre[1]) == pytest.approx((-0.04, 0.0), abs=0.01)
    assert constants.WHEEL_RADIUS < centre[2] < constants.WHEEL_RADIUS + 0.06
    assert sum(mass for name, mass in found.items() if name.startswith("body ")) == pytest.approx(found["total"])


def test_speed_and_turn_rate_are_what_the_robot_does_with_its_wheels_at_the_limit() -> None:
    found = measure()
    physics = open_scene(PIONEER_SCENE)
    limit = found["drive"]["wheel speed limit"]
    for commands, quantity, reading in (((limit, limit), "speed", 0), ((-limit, limit), "turn rate", 1)):
        physics.reset()
        for side, command in zip(("left_wheel", "right_wheel"), commands, strict=True):
            physics.data.ptr.ctrl[physics.model.ptr.actuator(side).id] = command
        physics.step(600)  # 3 s
        # At 7 rad/s on the spot the wheels slip a little.
        expected = found["performance of the drive"][quantity]
        assert physics.readings().velocity[reading] == pytest.approx(expected, rel=0.06)


def test_footprint_and_beams_of_known_shapes() -> None:
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody>
          <geom type="box" size="3 4 1"/>
          <geom type="cylinder" size="1 2" euler="90 0 0"/>
          <geom type="ellipsoid" size="1 2 3" pos="1 0 0"/>
          <geom type="capsule" size="1 2"/>
          <geom type="sphere" size="2" pos="0 0 5"/>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    z = np.array([0.0, 0.0, 1.0])
    spans = [extent(model, data, [geom], z) for geom in range(5)]
    np.testing.assert_allclose(spans, [(-1, 1), (-1, 1), (-3, 3), (-3, 3), (3, 7)], atol=1e-9)
    assert extent(model, data, [1, 2], np.array([0.0, 1.0, 0.0])) == pytest.approx((-2, 2))


def test_the_robot_stands_on_the_floor_and_its_laser_looks_ahead() -> None:
    found = measure()
    footprint = found["footprint"]
    assert 0.2 < footprint["height"] <= footprint["height, visual parts included"]
    assert footprint["caster"][2] == pytest.approx(0.0, abs=1e-3)
    assert 50 < found["performance of the drive"]["weight on the wheels"] < 100
    assert found["rangefinders range"]["beams"] == 40
    assert found["rangefinders range"]["field of view"] == pytest.approx(240)
    assert {"chase", "onboard"} <= set(found["cameras"])


def test_the_table_is_aligned_and_json_holds_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    robot_figures.main([])
    lines = capsys.readouterr().out.splitlines()
    (total,) = (line for line in lines if line.startswith("  total"))
    (track,) = (line for line in lines if line.startswith("  track"))
    assert total.index(" kg") == track.index(" m ")
    robot_figures.main(["nav_empty", "json=true"])
    read = json.loads(capsys.readouterr().out)
    assert read["mass"]["total"]["value"] == pytest.approx(float(total.split()[1]), rel=1e-3)
    assert read["drive"]["track"]["unit"] == "m"


SWIVEL = """<mujoco><worldbody>
  <geom name="floor" type="plane" size="1 1 1" friction="0.5"/>
  <body name="base"><freejoint name="base"/>
    <geom name="hull" type="box" size="0.2 0.1 0.1" pos="0 0 0.2" mass="8" contype="0" conaffinity="0"/>
    <site name="a" zaxis="1 0 0" pos="0.1 0 0.3"/><site name="b" zaxis="0 1 0" pos="0.1 0 0.3"/>
    <body name="left_wheel" pos="0 0.2 0.1"><joint name="left_wheel" axis="0 1 0"/>
      <geom name="left_wheel" type="cylinder" size="0.1 0.01" euler="90 0 0" mass="1" friction="0.8"/></body>
    <body name="right_wheel" pos="0 -0.2 0.1"><joint name="right_wheel" axis="0 1 0"/>
      <geom name="right_wheel" type="cylinder" size="0.1 0.01" euler="90 0 0" mass="1" friction="0.8"/></body>
    <body name="caster" pos="-0.2 0 0.05"><joint name="caster_swivel" axis="0 0 1"/>
      <geom name="fork" size="0.01" mass="0.1" contype="0" conaffinity="0"/>
      <body name="caster_wheel" pos="-0.05 0 0"><joint name="caster_wheel" axis="0 1 0"/>
        <geom name="caster_wheel" type="cylinder" size="0.05 0.01" euler="90 0 0" mass="0.1"/></body></body>
  </body></worldbody>
  <actuator><velocity name="left_wheel" joint="left_wheel" kv="2" gear="3"/>
    <velocity name="right_wheel" joint="right_wheel" kv="2" gear="3"/></actuator>
  <sensor><rangefinder name="range_00" site="a"/><rangefinder name="range_01" site="b"/>
    <rangefinder name="sonar_0" site="a" cutoff="3"/><gyro name="gyro" site="a"/></sensor>
</mujoco>"""


def test_a_robot_of_another_make_a_swivel_caster_sonar_no_limits() -> None:
    found = measure(SWIVEL)
    drive, performance = found["drive"], found["performance of the drive"]
    np.testing.assert_allclose(found["footprint"]["caster"], [-0.25, 0.0, 0.0], atol=1e-9)
    assert (drive["friction on the floor"], drive["velocity servo"], drive["track"]) == pytest.approx((0.8, 18.0, 0.4))
    assert drive["wheel inertia"] == pytest.approx(0.5 * 1 * 0.1**2)
    # Moments about the axle: 0.1 kg of fork 0.2 m and 0.1 kg of wheel 0.25 m behind it, borne 0.25 m behind it.
    share = 1 - (0.1 * 0.2 + 0.1 * 0.25) / 10.2 / 0.25
    assert performance["weight on the wheels"] == pytest.approx(100 * share)
    rings = [found[f"rangefinders {name}"] for name in ("range", "sonar")]
    assert [(ring["beams"], ring["range"]) for ring in rings] == [(2, None), (1, 3)]
    assert rings[0]["field of view"] == pytest.approx(90)
    printed = robot_figures.table(RobotQuantities(mujoco.MjModel.from_xml_string(SWIVEL)).sections)
    assert printed.count("not limited") == 6
    assert "range_00 … range_01, sonar_0" in printed
