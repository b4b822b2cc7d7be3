"""A six-joint arm with a spherical wrist: eight sets of joint angles lead to one pose of its
tool."""

from __future__ import annotations

import pytest

import rulesheets
import solver

JOINTS = {"q1": 25.0, "q2": 40.0, "q3": -70.0, "q4": 35.0, "q5": 50.0, "q6": -20.0}
COLUMNS = ((1, "n"), (2, "o"), (3, "a"))
"""Of the rotation of the tool: normal, orientation, approach."""

POSITION = """\
r = 0.45*cosd(q2) + 0.5*cosd(q2 + q3)
xw = r*cosd(q1)
yw = r*sind(q1)
zw = 0.4 + 0.45*sind(q2) + 0.5*sind(q2 + q3)
px = xw + 0.1*ax
py = yw + 0.1*ay
pz = zw + 0.1*az
"""
FOREARM = """\
ux = -sind(q2 + q3)*cosd(q1)
uy = -sind(q2 + q3)*sind(q1)
uz = cosd(q2 + q3)
vx = sind(q1)
vy = -cosd(q1)
vz = 0
wx = cosd(q2 + q3)*cosd(q1)
wy = cosd(q2 + q3)*sind(q1)
wz = sind(q2 + q3)
"""
WRIST = """\
m11 = cosd(q4)*cosd(q5)*cosd(q6) - sind(q4)*sind(q6)
m12 = -cosd(q4)*cosd(q5)*sind(q6) - sind(q4)*cosd(q6)
m13 = cosd(q4)*sind(q5)
m21 = sind(q4)*cosd(q5)*cosd(q6) + cosd(q4)*sind(q6)
m22 = -sind(q4)*cosd(q5)*sind(q6) + cosd(q4)*cosd(q6)
m23 = sind(q4)*sind(q5)
m31 = -sind(q5)*cosd(q6)
m32 = sind(q5)*sind(q6)
m33 = cosd(q5)
"""
TOOL = "".join(
    f"{tool}{axis} = u{axis}*m1{k} + v{axis}*m2{k} + w{axis}*m3{k}\n"
    for k, tool in COLUMNS
    for axis in "xyz"
)
TOOL_IN_THE_FOREARM = "".join(
    f"m{row}{k} = {axis}x*{tool}x + {axis}y*{tool}y + {axis}z*{tool}z\n"
    for k, tool in COLUMNS
    for row, axis in enumerate("uvw", 1)
)


def test_eight_sets_of_angles_lead_to_a_pose() -> None:
    forward = solver.solve(rulesheets.loads(POSITION + FOREARM + WRIST + TOOL), JOINTS)
    pose = {
        name: forward[name]
        for name in ("px", "py", "pz", *(t + c for _, t in COLUMNS for c in "xyz"))
    }
    found = solver.solve(rulesheets.loads(POSITION + FOREARM + WRIST + TOOL_IN_THE_FOREARM), pose)
    assert str(found.status) == "solved"
    assert len(found.solutions) == 8
    assert {name: found[name] for name in JOINTS} == pytest.approx(JOINTS)
