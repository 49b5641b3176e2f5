"""A step of the arm's laws beside general inverse kinematics, on the same arm and path.

Two things of ours are measured, on the line that turns back at the elbow. A *cycle* is what the
loop calls, `update`, over a whole run: every law plans beforehand and the cycle reads the plan. A
*step* is a period of the planning of `esc` and `esc-paper`, by Runge and Kutta's method: what the
same law would cost in the loop if it did not plan. Each library takes a step from the same joints
to the pose that the same line asks for a period later, with its own fastest interface and with the
joints' rate limits where it knows them. All of them are called from Python.

None of the libraries passes the singularity that the law is for.
"""

import math
import time
from statistics import median

import numpy as np
import pytest

from controllers.arm.esc import Esc, EscPaper
from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of
from controllers.arm.law import MotionEnd
from controllers.arm.look_ahead import LookAhead
from controllers.arm.paths import Line, TurnBack
from controllers.arm.plain import DampedLeastSquares, Inverse, ServoHalt
from controllers.arm.trajectories import make_trajectory
from controllers.arm.types import AT_REST, ArmReference, ArmState

pytestmark = pytest.mark.benchmark

GEOMETRY = ArmGeometry()
PATH = TurnBack()
Q = PATH.start
PERIOD = 5e-3
ROUNDS = 9
MOTIONS = 1000
"""That are ready to be gone through: more than are."""
LAWS = {"esc": Esc, "esc-paper": EscPaper}
PAST_THE_WRIST = Line(tuple(map(math.radians, (0.0, 20.0, 90.0, 90.0, 1.0, 0.0))), None, (0, 0, 1))
CYCLES = {
    "esc": (Esc, PATH),
    "esc-paper": (EscPaper, PATH),
    "inverse": (Inverse, PATH),
    "dls": (DampedLeastSquares, PATH),
    "servo-halt": (ServoHalt, PATH),
    "look-ahead": (LookAhead, PAST_THE_WRIST),
}
"""Every law, on a path that it takes."""
MOST = {"pinocchio + dls": 0.4, "pink": 0.08, "mink": 0.11, "placo": 2.4}
"""What our step may cost over a step of each library: twice what was measured."""
MOST_OF_A_CYCLE = {"pinocchio + dls": 0.2, "pink": 0.05, "mink": 0.05, "placo": 0.5}
"""What a cycle of each law may cost over a step of each library."""


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
    """Return the pose of the line one period ahead, as a matrix."""
    pose = make_trajectory(dimensions_of(GEOMETRY), PATH).pose(PERIOD)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = pose.rotation, pose.position
    return matrix


def prepared(kind):
    law = kind(kind.Settings(), GEOMETRY, PERIOD)
    return law, law.prepare(PATH)


def ours(kind):
    """Return the next step of the motion, which begins anew when it is done.

    What is found once of a motion, its regions, is found beforehand.
    """
    law, plan = prepared(kind)
    trajectory = make_trajectory(dimensions_of(GEOMETRY), PATH)
    motions = [law.move(trajectory, MotionEnd()) for _ in range(MOTIONS)]
    left, motion = 0, motions[-1]

    def step():
        nonlocal left, motion
        if left == 0:
            motion = motions.pop()
            left = len(plan.t) - 1
        left -= 1
        return next(motion)

    return step


def cycle(kind, path):
    """Return the next `update` of a run, as the loop calls it; the run begins anew when it ends."""
    law = kind(kind.Settings(), GEOMETRY, PERIOD)
    plan = law.prepare(path)
    state = ArmState(0.0, tuple(Q), AT_REST)
    reference = ArmReference(tuple(Q), AT_REST, following=True)
    left = 0

    def update():
        nonlocal left
        if left == 0:
            law.reset(state)
            left = len(plan.t)
        left -= 1
        return law.update(state, reference)

    return update


def pinocchio_dls():
    """Forward kinematics, Jacobian and error of Pinocchio; numpy solves the damped equations."""
    pin = pytest.importorskip("pinocchio")
    model = pin.buildModelFromXML(urdf())
    data = model.createData()
    frame = model.getFrameId("tool")
    wanted = pin.SE3(wanted_pose())
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
    task.set_target(pin.SE3(wanted_pose()))
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
    task.set_target(library.SE3.from_matrix(wanted_pose()))
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
    solver.add_frame_task("tool", wanted_pose()).configure("tool", "soft", 1.0, 1.0)

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
    steps, missing = {name: ours(kind) for name, kind in LAWS.items()}, []
    others = {"pinocchio + dls": pinocchio_dls, "pink": pink, "mink": mink}
    for name, make in {**others, "placo": lambda: placo(tmp_path)}.items():
        try:
            steps[name] = make()
        except pytest.skip.Exception as absent:
            missing.append(f"{name}: {absent}")
    if len(steps) == len(LAWS):
        pytest.skip("; ".join(missing))
    theirs = [name for name in steps if name not in LAWS]
    steps |= {f"cycle of {name}": cycle(*each) for name, each in CYCLES.items()}
    rounds = {name: [] for name in steps}
    for _ in range(ROUNDS):  # in turn, so that a slow spell hits all of them
        for name, step in steps.items():
            rounds[name].append(cost_of(step))
    # Of the better half: what else the machine did is in the others.
    cost = {name: median(sorted(costs)[: ROUNDS // 2 + 1]) for name, costs in rounds.items()}
    ours_alone = [name for name in cost if name not in theirs]
    ratios = {(mine, name): cost[mine] / cost[name] for mine in ours_alone for name in theirs}
    for name, each in cost.items():
        over = {f"over {other}": ratios[name, other] for other in theirs if name not in theirs}
        table(what=name, us=1e6 * each, **over)
    for reason in missing:
        table(what="not measured", reason=reason)
    for (mine, name), ratio in ratios.items():
        most = MOST[name] if mine in LAWS else MOST_OF_A_CYCLE[name]
        assert ratio <= most, f"{mine} over {name}"


@pytest.mark.parametrize("kind", LAWS.values(), ids=LAWS)
def test_other_libraries_solve_the_same_problem(kind):
    """Away from singularities the damped inverse has to agree with ours, or it is no comparison."""
    theirs = pinocchio_dls()()
    _, plan = prepared(kind)
    moved = (plan.positions[1] - plan.positions[0]) / PERIOD
    np.testing.assert_allclose(theirs, moved, atol=2e-3)


def cost_of(step, least=0.05):
    """Return the CPU time of one call, s."""
    calls = 0
    began = time.process_time()
    while time.process_time() - began < least:
        for _ in range(50):
            step()
        calls += 50
    return (time.process_time() - began) / calls
