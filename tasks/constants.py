"""Constants of the robot, its laser and the task, each with unit and source.

Sources: [paper] Xie et al., ICRA 2018; [code] the code released with it; [p3dx] Pioneer 3-DX manual as in the Webots
model; [hokuyo] URG-04LX data sheet; [aria] p3dx-sh.p of the ARIA library. The robot's own constants must agree with
models/mjcf/pioneer/pioneer.xml; a test compares them with the compiled model.
"""

from math import pi

WHEEL_RADIUS = 0.0975  # m; [p3dx]
TRACK = 0.330  # m between the wheels' contact points; [p3dx]
WHEEL_SPEED_LIMIT = 12.3  # rad/s; [p3dx], 1.2 m/s

TURN_RATE_LIMIT = 5 / 3 * pi  # rad/s, 300 degrees a second; [p3dx]

NUM_BEAMS = 40  # kept of the laser's beams; [code]
FIELD_OF_VIEW = 240.0  # degrees; [hokuyo]
MIN_RANGE = 0.02  # m; [hokuyo]
MAX_RANGE = 5.6  # m; [hokuyo]

MIN_SONAR_RANGE = 0.1  # m; [aria]
MAX_SONAR_RANGE = 5.0  # m; [aria]

MAX_LINEAR_VELOCITY = 0.5  # m/s; [code]
MAX_ANGULAR_VELOCITY = pi / 3  # rad/s; [code]

PHYSICS_TIMESTEP = 0.005  # s; models/mjcf/rooms/common.xml
CONTROL_TIMESTEP = 0.2  # s; [paper], 43 steps = 8.6 s
GOAL_RADIUS = 0.3  # m; [code]
TIME_LIMIT_STEPS = 200  # [code]
NUM_SCANS = 3  # stacked, newest first; [code]
