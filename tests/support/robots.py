"""Small robots for tests, as MJCF files of users would have them."""

from pathlib import Path

# Names of ROS, a place and a heading of its own, a wheel whose joint turns the other way, a gear, no name of a base.
ROBOT = """<mujoco model="mine">
  <compiler angle="radian"/>
  <option timestep="0.001"/>
  <asset><material name="floor" rgba="0 1 0 1"/></asset>
  <worldbody>
    <light pos="0 0 3"/>
    <geom name="floor" type="plane" size="5 5 1"/>
    <frame pos="1 0 0" euler="0 0 0.7">
      <body name="base_link" pos="0 0 0.05" euler="0 0 1">
        <freejoint/>
        <geom name="chassis" type="box" size="0.1 0.08 0.03" pos="-0.02 0 0.05" mass="2" material="floor"/>
        <geom type="sphere" size="0.02" pos="-0.08 0 -0.03" {caster}/>
        <body name="wheel_left_link" pos="0 0.1 0" quat="0.7071068 -0.7071068 0 0">
          <joint name="wheel_left_joint" axis="0 0 1"/>
          <geom type="{wheel}" size="0.05 {width}" mass="0.1"/>
        </body>
        <body name="wheel_right_link" pos="0 -0.1 0" quat="0.7071068 -0.7071068 0 0">
          <joint name="wheel_right_joint" axis="0 0 -1"/>
          <geom type="{wheel}" size="0.05 {width}" mass="0.1"/>
        </body>
        {laser}
      </body>
    </frame>
  </worldbody>
  <actuator>
    <velocity joint="wheel_left_joint" kv="{kv}" gear="3"/>
    <{servo} name="right_motor" joint="wheel_right_joint" {gain} ctrlrange="-20 20"/>
  </actuator>
  {more}
</mujoco>
"""
LASER = (
    '<body name="base_scan" pos="0.05 0 0.12"><geom name="head" type="cylinder" size="0.03 0.02" mass="0.1"/></body>'
)
SMOOTH = 'condim="1" friction="0 0 0" priority="1"'


def write_robot(folder: Path, name: str = "robot.xml", **changes: str) -> str:
    """A robot's file; changes are of `caster`, `wheel`, `width`, `laser`, `kv`, `servo`, `gain`, `more`."""
    usual = {"caster": SMOOTH, "wheel": "ellipsoid", "width": "0.05 0.01", "laser": LASER, "kv": "2", "more": ""}
    path = folder / name
    path.write_text(ROBOT.format(**usual | {"servo": "velocity", "gain": 'kv="2"'} | changes))
    return str(path)
