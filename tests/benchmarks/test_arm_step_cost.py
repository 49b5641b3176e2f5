"""One step of the arm's law beside general inverse kinematics, on the same arm in the same run.

Pose and twist in, six joint rates out, called from Python. Every library gets the same model, its
own fastest interface and joint rate limits where it knows them; ours has them on.

What is wanted of the law: at most a fifth of Pinocchio with damped least squares, of Pink and of
mink, and half of placo.
"""

import math
import time
from statistics import median

import numpy as np
import pytest
from controllers.arm.step import make_step

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward
from controllers.arm.region import region_for_twist

pytestmark = pytest.mark.benchmark

GEOMETRY = ArmGeometry()
Q = tuple(math.radians(angle) for angle in (0, 30, 115, 30, -50, 0))
LINEAR, ANGULAR = (0.07, 0.0, 0.0), (0.07, 0.0, 0.0)
PERIOD = 5e-3
ROUNDS = 7
WANTED = {"pinocchio + dls": 1 / 5, "pink": 1 / 5, "mink": 1 / 5, "placo": 1 / 2}


def urdf():
    """Return the paper's arm; a body per joint."""
    g = GEOMETRY
    joints = (
        ((0, 0, g.base_height), (0, 0, 1)),
        ((0, 0, 0), (0, 1, 0)),
        ((0, 0, g.a2), (0, 1, 0)),
        ((0, 0, g.a3), (0, 0, 1)),
        ((0, 0, 0), (0, 1, 0)),
        ((0, 0, 0), (0, 0, 1)),
    )
    inertia = (
        '<inertial><mass value="1"/>'
        '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="l{k}">{inertia}</link>' for k in range(7))
    text = ""
    for k, ((x, y, z), (ax, ay, az)) in enumerate(joints):
        limit = GEOMETRY.rate_limits[k]
        text += (
            f'<joint name="q{k + 1}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>'
            f'<origin xyz="{x} {y} {z}"/><axis xyz="{ax} {ay} {az}"/>'
            f'<limit lower="-6.3" upper="6.3" effort="100" velocity="{limit}"/></joint>'
        )
    tool = (
        '<link name="tool"/><joint name="mount" type="fixed"><parent link="l6"/>'
        f'<child link="tool"/><origin xyz="0 0 {g.d6}"/></joint>'
    )
    return f'<robot name="arm">{links}{text}{tool}</robot>'


def mjcf():
    g = GEOMETRY
    mass = '<inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/>'
    return f"""
    <mujoco><compiler angle="radian"/><worldbody>
      <body pos="0 0 {g.base_height}">{mass}<joint name="q1" axis="0 0 1"/>
       <body>{mass}<joint name="q2" axis="0 1 0"/>
        <body pos="0 0 {g.a2}">{mass}<joint name="q3" axis="0 1 0"/>
         <body pos="0 0 {g.a3}">{mass}<joint name="q4" axis="0 0 1"/>
          <body>{mass}<joint name="q5" axis="0 1 0"/>
           <body>{mass}<joint name="q6" axis="0 0 1"/>
            <site name="tool" pos="0 0 {g.d6}"/>
      </body></body></body></body></body></body>
    </worldbody></mujoco>"""


def wanted_pose():
    """Return the pose one period ahead, as a matrix too."""
    position, rotation = forward(dimensions_of(GEOMETRY), Q)
    ahead = tuple(a + PERIOD * b for a, b in zip(position, LINEAR, strict=True))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, ahead
    return ahead, rotation, matrix


def ours():
    step = make_step(GEOMETRY, region_for_twist(GEOMETRY, 0.07, 0.07))
    position, rotation, _ = wanted_pose()
    return lambda: step(Q, position, rotation, LINEAR, ANGULAR)


def pinocchio_dls():
    """Forward kinematics, Jacobian and error of Pinocchio; numpy solves the damped equations."""
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(urdf())
    data = model.createData()
    frame = model.getFrameId("tool")
    wanted = pin.SE3(wanted_pose()[2])
    q, damping = np.array(Q), 1e-4 * np.eye(6)
    limits = np.array(GEOMETRY.rate_limits)

    def step():
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacement(model, data, frame)
        J = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL)
        error = pin.log6(data.oMf[frame].actInv(wanted)).vector / PERIOD
        rates = J.T @ np.linalg.solve(J @ J.T + damping, error)
        return rates / max(1.0, (np.abs(rates) / limits).max())

    return step


def pink():
    pytest.importorskip("pink")
    pin = pytest.importorskip("pinocchio")
    from pink import Configuration, solve_ik
    from pink.tasks import FrameTask

    model = pin.buildModelFromXML(urdf())
    configuration = Configuration(model, model.createData(), np.array(Q))
    task = FrameTask("tool", position_cost=1.0, orientation_cost=1.0)
    task.set_target(pin.SE3(wanted_pose()[2]))
    solver = qp_solver()

    def step():
        configuration.update(np.array(Q))
        return solve_ik(configuration, [task], PERIOD, solver=solver)

    return step


def mink():
    library = pytest.importorskip("mink")
    import mujoco

    model = mujoco.MjModel.from_xml_string(mjcf())
    configuration = library.Configuration(model, np.array(Q))
    task = library.FrameTask("tool", "site", position_cost=1.0, orientation_cost=1.0)
    task.set_target(library.SE3.from_matrix(wanted_pose()[2]))
    limit = library.VelocityLimit(
        model, {f"q{k + 1}": rate for k, rate in enumerate(GEOMETRY.rate_limits)}
    )
    solver = qp_solver()

    def step():
        configuration.update(np.array(Q))
        return library.solve_ik(configuration, [task], PERIOD, solver, limits=[limit])

    return step


def placo(folder):
    library = pytest.importorskip("placo", exc_type=ImportError)
    (folder / "robot.urdf").write_text(urdf())
    robot = library.RobotWrapper(str(folder), library.Flags.ignore_collisions)
    for k in range(6):
        robot.set_joint(f"q{k + 1}", Q[k])
    robot.update_kinematics()
    solver = library.KinematicsSolver(robot)
    solver.mask_fbase(True)
    solver.dt = PERIOD
    solver.enable_velocity_limits(True)
    solver.add_frame_task("tool", wanted_pose()[2]).configure("tool", "soft", 1.0, 1.0)

    def step():
        rates = solver.solve(False)
        robot.update_kinematics()
        return rates

    return step


def qp_solver():
    """Return the quickest solver of quadratic programs that is there."""
    import qpsolvers

    for name in ("daqp", "quadprog", "proxqp"):
        if name in qpsolvers.available_solvers:
            return name
    pytest.skip("no solver of quadratic programs is installed")
    return ""


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_arm_step_cost(table, tmp_path):
    steps, missing = {"ours": ours()}, []
    others = {"pinocchio + dls": pinocchio_dls, "pink": pink, "mink": mink}
    for name, make in {**others, "placo": lambda: placo(tmp_path)}.items():
        try:
            steps[name] = make()
        except pytest.skip.Exception as absent:
            missing.append(f"{name}: {absent}")
    if len(steps) == 1:
        pytest.skip("; ".join(missing))
    for step in steps.values():
        step()  # compiles, fills caches
    rounds = {name: [] for name in steps}
    for _ in range(ROUNDS):  # in turn, so that a slow spell hits all of them
        for name, step in steps.items():
            rounds[name].append(cost_of(step))
    cost = {name: median(costs) for name, costs in rounds.items()}
    for name, each in cost.items():
        table(
            what=name, us=1e6 * each, ours_over_it=cost["ours"] / each, wanted=WANTED.get(name, 1)
        )
    for reason in missing:
        table(what="not measured", reason=reason)
    for name in cost.keys() - {"ours"}:
        assert cost["ours"] <= WANTED[name] * cost[name], name


def test_other_libraries_solve_the_same_problem():
    """Away from singularities the damped inverse has to agree with ours, or it is no comparison."""
    theirs = pinocchio_dls()()
    arm = dimensions_of(GEOMETRY)
    step = make_step(GEOMETRY, region_for_twist(GEOMETRY, 0.07, 0.0), feedback=0.0)
    same = forward(arm, Q)
    rates = step(Q, same.position, same.rotation, LINEAR, (0.0, 0.0, 0.0))
    np.testing.assert_allclose(theirs, rates, atol=2e-3)


def cost_of(step, least=0.05):
    """Return the CPU time of one call, s."""
    calls = 0
    began = time.process_time()
    while time.process_time() - began < least:
        for _ in range(50):
            step()
        calls += 50
    return (time.process_time() - began) / calls
