"""Properties of the robot against analysis."""

import json
import math

import mujoco
import numpy as np
import pytest

from tasks.room_geometry.geom_shapes import extent
from tasks.scene.loading import load_model, open_scene
from tools import robot_figures
from tools.robot.robot_model import RobotModel
from tools.robot.scene_argument import ROBOT_SCENE


def robot() -> RobotModel:
    return RobotModel(load_model(ROBOT_SCENE))


def test_mass_and_inertia_are_those_of_the_free_joints_block_of_the_mass_matrix() -> None:
    found = robot()
    matrix = np.zeros((found.model.nv, found.model.nv))
    mujoco.mj_fullM(found.model, found.data, matrix)
    start = int(found.model.joint("base").dofadr[0])
    free = matrix[start : start + 6, start : start + 6]
    np.testing.assert_allclose(free[:3, :3], found.mass() * np.eye(3), atol=1e-9)
    centre = found.centre_of_mass()
    shift = found.mass() * (centre @ centre * np.eye(3) - np.outer(centre, centre))
    np.testing.assert_allclose(free[3:, 3:], found.inertia() + shift, atol=1e-9)
    assert sum(found.masses().values()) == pytest.approx(found.mass())


def test_speed_and_turn_rate_are_what_the_robot_does_with_its_wheels_at_the_limit() -> None:
    found = robot()
    performance = robot_figures.measure_robot(found)["performance of the drive"]
    physics = open_scene(ROBOT_SCENE)
    limit = found.wheel_speed_limit()
    for commands, quantity, reading in (((limit, limit), "speed", 0), ((-limit, limit), "turn rate", 1)):
        physics.reset()
        for side, command in zip(("left_wheel", "right_wheel"), commands, strict=True):
            physics.data.ptr.ctrl[physics.model.ptr.actuator(side).id] = command
        physics.step(600)  # 3 s
        # At 7 rad/s on the spot the wheels slip a little.
        assert physics.velocity()[reading] == pytest.approx(performance[quantity].value, rel=0.06)


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
    found = robot()
    low, high = found.footprint()["z"]
    assert low == pytest.approx(0.0, abs=1e-3)
    assert 0.2 < high <= found.overall_height()
    assert 0.5 < found.load_on_wheels() < 1.0
    ring = found.rangefinder_rings()["range"]
    assert ring.beams == 40
    assert ring.field_of_view == pytest.approx(4 / 3 * math.pi)
    assert {"chase", "onboard"} <= set(found.cameras())


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
    found = RobotModel(mujoco.MjModel.from_xml_string(SWIVEL))
    caster = found.caster_contact()
    assert caster is not None
    np.testing.assert_allclose(caster, [-0.25, 0.0, 0.0], atol=1e-9)
    assert (found.friction(), found.servo_gain(), found.track()) == pytest.approx((0.8, 18.0, 0.4))
    assert found.spin_inertia() == pytest.approx(0.5 * 1 * 0.1**2)
    # Moments about the axle: 0.1 kg of fork 0.2 m and 0.1 kg of wheel 0.25 m behind it, borne 0.25 m behind it.
    assert found.load_on_wheels() == pytest.approx(1 - (0.1 * 0.2 + 0.1 * 0.25) / 10.2 / 0.25)
    assert [(name, ring.beams, ring.range) for name, ring in found.rangefinder_rings().items()] == [
        ("range", 2, 0),
        ("sonar", 1, 3),
    ]
    assert found.rangefinder_rings()["range"].field_of_view == pytest.approx(math.pi / 2)
    printed = robot_figures.table(robot_figures.measure_robot(found))
    assert printed.count("not limited") == 6
    assert "range_00 … range_01, sonar_0" in printed
