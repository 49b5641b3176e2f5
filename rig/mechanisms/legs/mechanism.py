"""Two walking legs on servo drives."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from controllers.gait.balance import GRAVITY, from_edge
from controllers.gait.corrections import Corrections
from controllers.gait.footsteps import FootstepsSettings, LegsMotion, phases_of
from controllers.gait.geometry import AXIS_NAMES, LegGeometry
from controllers.gait.law import AnyGaitLaw, GaitLaw
from controllers.gait.motions import GaitRequest
from controllers.gait.plan import GaitPlan
from controllers.gait.types import GaitModel, LegsCommand, LegsReference, LegsState
from controllers.slowed_law import SlowedLaw
from rig.hal import Device, Vector
from rig.hal.columns import Column
from rig.hal.motion import Motion, Note, Segment
from rig.mechanisms.legs.dimensions import described
from rig.mechanisms.legs.facts import plan_facts
from rig.mechanisms.legs.fall import FallWatch
from rig.mechanisms.legs.ground import prints_off_ground
from rig.mechanisms.legs.halt import Halt
from rig.mechanisms.legs.remarks import remarks_of_plan, remarks_on_edges, remarks_on_jumps
from rig.mechanisms.legs.sensors import COLUMNS, BalanceSensors
from rig.mechanisms.legs.settings import LegsSettings
from rig.mechanisms.legs.stance import check_stance
from rig.mechanisms.servo.axes import AxisLimits, Kinds
from rig.mechanisms.servo.columns import servo_columns
from rig.mechanisms.servo.planned import PlannedAxes, PlannedMotion
from rig.mechanisms.servo.settings import ServoLimits

if TYPE_CHECKING:
    from rig.hal.hindsight import Logged

_FINE = 1e-3
"""Peak rates are differences over this time, s, whatever the loop's rate: a plain inverse's peak
grows as the steps get finer."""
_FINE_SAMPLES = 120_000
"""No more of them: of a walk of half an hour they would be gigabytes."""


class PlannedGait(PlannedMotion[LegsReference]):
    """A plan of a law as the loop follows it, with what is known of it beforehand.

    Parameters are those of `plan_facts`; `corrections` are the law's, `remarks` more to be told.
    """

    def __init__(
        self,
        plan: GaitPlan,
        fine: GaitPlan,
        distance: float = 0.0,
        flat: GaitPlan | None = None,
        corrections: Corrections | None = None,
        remarks: Sequence[Note] = (),
    ) -> None:
        self.plan = plan
        self._corrections = corrections
        self._doubt = ""
        self.watches = corrections is not None and corrections.feels
        columns = [
            plan.waist,
            plan.feet.reshape(len(plan.t), 6),
            plan.balance.centre[:, :2],
            plan.balance.zero_moment,
            plan.balance.static_margin,
            plan.balance.margin,
            plan.phase_number,
            plan.path,
            plan.yaw,
            plan.attitudes.reshape(len(plan.t), 6),
            np.array([p.phase.standing for p in plan.phases], float)[plan.phase_number],
        ]
        super().__init__(np.column_stack(columns))
        self.facts = plan_facts(plan, fine, distance, flat)
        self.remarks = (*remarks_of_plan(fine), *remarks_on_jumps(plan), *remarks)

    @property
    def duration(self) -> float:
        """How long it takes, s."""
        return self.plan.duration

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The whole motion, and each phase."""
        return (
            Segment("all", 0.0, self.plan.duration),
            *(Segment(*segment) for segment in self.plan.segments),
        )

    def see(self, t: float, state: object, here: object) -> Sequence[Note]:
        """Say once that balance is not corrected any more, and why."""
        doubt = "" if self._corrections is None else self._corrections.doubt
        if doubt == self._doubt:
            return ()
        self._doubt = doubt
        return (Note("balance", f"balance is no longer corrected: {doubt}"),) if doubt else ()

    def at(self, t: float) -> LegsReference:
        """Return what the legs should do at `t`."""
        return self.plan.at(t)


def _planned(
    settings: LegsSettings, asked: GaitRequest, law: AnyGaitLaw, period: float, share: float
) -> PlannedGait:
    """Return the plan of a law for `share` of the loop's period, with that share of its speed."""
    reference = cast("LegsMotion", asked)

    def stretched(plan: GaitPlan) -> GaitPlan:
        return plan if share == 1.0 else plan.stretched(share, settings.balance)

    phases = phases_of(reference, settings.geometry, settings.balance.min_margin)
    asked_time = sum(phase.duration for phase in phases)
    step = share * min(max(_FINE, asked_time / _FINE_SAMPLES), period)
    finer = law.finer(step) if isinstance(law, GaitLaw) else law.at_period(step)
    fine = stretched(finer.prepare(reference))
    flat = None
    if reference.bob is not None:
        flat = stretched(
            law.at_period(share * period).prepare(cast("LegsMotion", reference.without_bob()))
        )
    distance = reference.advance(settings.geometry)
    plan = stretched(law.prepare(reference))
    corrections = law.corrections if isinstance(law, GaitLaw) else None
    edges = remarks_on_edges(plan, settings.sag)
    if isinstance(reference, FootstepsSettings):
        edges = tuple([Note(kind, reference.with_line(words)) for kind, words in edges])
    return PlannedGait(plan, fine, distance, flat, corrections, edges)


class Legs(PlannedAxes[LegsSettings, LegsState, LegsReference, LegsCommand]):
    """The loop's view of two legs; parameters are those of `PlannedAxes`."""

    Settings = LegsSettings
    section = "legs"
    kinds = Kinds(LegsState, LegsReference, LegsCommand)

    columns: Sequence[Column] = (
        *servo_columns(AXIS_NAMES),
        *(Column(f"reference.waist_{axis}", "m", "planned waist") for axis in "xyz"),
        *(
            Column(f"reference.{leg}_foot_{axis}", "m", "planned sole under the ankle")
            for leg in ("right", "left")
            for axis in "xyz"
        ),
        *(Column(f"plan.mass_{axis}", "m", "centre of mass") for axis in "xy"),
        *(Column(f"plan.zero_moment_{axis}", "m", "zero-moment point") for axis in "xy"),
        Column("plan.static_margin", "m", "centre of mass inside the support polygon"),
        Column("plan.margin", "m", "the nearer of both inside the support polygon"),
        Column("plan.phase", "", "number of the phase"),
        Column("plan.path", "", "path parameter in it, 0 … 1"),
        Column("reference.waist_yaw", "rad", "planned heading of the waist"),
        *(
            Column(f"reference.{leg}_foot_{angle}", "rad", "how the planned sole lies")
            for leg in ("right", "left")
            for angle in ("roll", "pitch", "yaw")
        ),
        *(Column(f"plan.stands_{leg}", "", "1 if this foot stands") for leg in ("right", "left")),
    )

    def __init__(
        self, settings: LegsSettings, devices: Mapping[str, Device], period: float
    ) -> None:
        super().__init__(settings, devices, period)
        self.motion: PlannedGait | None = None
        self._halt: Halt | None = None
        self._added: Vector | None = None
        self._corrects = settings.stabiliser is not None or settings.sag is not None
        self._sensors = BalanceSensors.pick(settings, devices)
        if self._sensors is not None:
            self.columns = (*type(self).columns, *COLUMNS)
        weight = GRAVITY * settings.geometry.masses.total
        self._fall = FallWatch(settings.fall_tilt, weight, period)

    @classmethod
    def axis_limits(cls, settings: LegsSettings) -> AxisLimits:
        """Return the twelve joints and what they may do."""
        limits = settings.geometry.limits
        return AxisLimits(
            AXIS_NAMES,
            tuple([lower for lower, _ in limits]),
            tuple([upper for _, upper in limits]),
            (settings.geometry.max_rate,) * len(AXIS_NAMES),
        )

    @classmethod
    def geometry_of(cls, settings: LegsSettings) -> LegGeometry:
        """Return the dimensions that the plant is made with."""
        return settings.geometry

    @classmethod
    def described(cls, settings: LegsSettings) -> tuple[tuple[str, str], ...]:
        """Return what its dimensions come to; see `Mechanism.described`."""
        return described(settings.geometry)

    @classmethod
    def limits_of(cls, settings: LegsSettings) -> ServoLimits:
        """Return the limits; see `Mechanism.limits_of`."""
        return settings.limits

    @classmethod
    def model_of(cls, settings: LegsSettings) -> GaitModel:
        """Return what the laws are told of the legs."""
        return GaitModel(settings.geometry, settings.balance, settings.stabiliser, settings.sag)

    @classmethod
    def plan(
        cls, settings: LegsSettings, reference: object, controller: AnyGaitLaw, period: float
    ) -> PlannedGait:
        """Have the law work out the whole motion; see `Mechanism.plan`."""
        if not isinstance(reference, GaitRequest):
            raise ValueError("the reference is not one for legs")
        return _planned(settings, reference, controller, period, 1.0)

    @classmethod
    def plant_unlike(
        cls, settings: LegsSettings, reference: object, plant: object
    ) -> tuple[str, ...]:
        """Say which footprints lie higher or lower than the simulated ground; see `Mechanism`."""
        return prints_off_ground(settings.geometry, reference, plant)

    @classmethod
    def derated(cls, settings: LegsSettings, effort: float, speed: float) -> LegsSettings:
        """Return the settings with a share of the joints' rate; see `Mechanism.derated`.

        Torque is limited by the drives.
        """
        its = settings.geometry
        return replace(settings, geometry=replace(its, max_rate=speed * its.max_rate))

    @classmethod
    def slowed(
        cls,
        settings: LegsSettings,
        reference: object,
        controller: AnyGaitLaw,
        period: float,
        share: float,
    ) -> tuple[object, PlannedGait] | None:
        """Have the law work the motion out for as many more cycles; see `Mechanism.slowed`."""
        if not isinstance(reference, GaitRequest):
            return None
        law = controller.at_period(share * period)
        return SlowedLaw(law, share, LegsCommand), _planned(settings, reference, law, period, share)

    def remarks(self, logged: "Logged") -> tuple[Note, ...]:
        """Return when a simulated robot fell, if it did; see `Mechanism.remarks`."""
        if self.motion is None:
            return ()
        from rig.mechanisms.legs.hindsight import remark_on_fall

        return remark_on_fall(logged, [planned.phase.name for planned in self.motion.plan.phases])

    @property
    def brakes_itself(self) -> bool:  # type: ignore[override]
        """Whether `balanced_command` brings a motion to rest: the walk, and not the way to it.

        On that way control brakes, on the planned path: there joints that slow down one by one
        would tilt the robot until it falls.
        """
        return self._followed > 0

    def attach(self, controller: Any, motion: Motion[LegsReference]) -> None:
        """Take the motion if it is one that a law has planned."""
        self.motion = motion if isinstance(motion, PlannedGait) else None

    def check_still(self, home: LegsReference) -> None:
        """Raise if legs that are to walk cannot stand as their encoders say, at `home`."""
        bound = self.settings.start_tilt
        if bound is not None and self.motion is not None:
            check_stance(self.settings.geometry, home.positions, bound)

    def read(self, now: float) -> LegsState:
        """Assemble the state of joints and sensors; see `Mechanism.read`."""
        state = super().read(now)
        if self._sensors is None:
            return state
        sensing = self._sensors.read(now)
        self._age = max(self._age, self._sensors.age)
        return state._replace(sensing=sensing)

    def recall(self, logged: Mapping[str, float]) -> LegsState:
        """Assemble the same from the log; see `Mechanism.recall`."""
        state = super().recall(logged)
        return (
            state if self._sensors is None else state._replace(sensing=self._sensors.recall(logged))
        )

    def check(self, state: LegsState, now: float) -> None:
        """Raise if a joint's state is not safe, or the robot falls; see `Mechanism.check`."""
        if state.sensing is not None:
            self._fall.see(state.sensing)  # what joints do of a robot that lies follows from it
        super().check(state, now)

    def check_command(self, reference: LegsReference, command: LegsCommand) -> None:
        """See `ServoAxes.check_command`; notes what a law has added to the plan, for a stop."""
        super().check_command(reference, command)
        if reference.follow and self._corrects:
            planned = reference.positions
            self._added = tuple([a - b for a, b in zip(command.positions, planned, strict=True)])

    def start_limiting(self, state: LegsState) -> None:
        """See `ServoAxes.start_limiting`."""
        super().start_limiting(state)
        self._halt = None
        self._added = None

    def resting_command(self, state: LegsState) -> LegsCommand:
        """See `ServoAxes.resting_command`; in mid-walk both legs come to rest on their path."""
        rest = super().resting_command(state)
        if not self._braking or self.motion is None or not self._followed:
            return rest
        self._braking = False
        self._halt = Halt(self.motion.plan, self._followed - 1, self.limits.acceleration)
        self._stop = self._kinds.command(self._with_added(self._halt.end), self._still)
        return self._stop

    def _with_added(self, positions: Vector) -> Vector:
        """Return positions of the plan with the corrections that a stop keeps as they are."""
        if self._added is None:
            return positions
        return tuple([a + b for a, b in zip(positions, self._added, strict=True)])

    def limit(self, command: LegsCommand) -> LegsCommand:
        """See `ServoAxes.limit`."""
        if self._halt is not None:
            command = LegsCommand(self._with_added(self._halt.advance()), self._still)
        return super().limit(command)

    def pose_held(self) -> str | None:
        """Say at which instant of the walk the legs are held, and how safely they stand there.

        A fault holds the setpoints that were sent last. That is the nearest instant at which the
        robot stands safely: a plan that has any other is refused beforehand.
        """
        if self._fall.has_fallen:
            return (
                "the joints are held as they are, for the robot falls or lies: bear its weight "
                "before they are let go of"
            )
        if self.motion is None or not self._followed:
            return None
        plan = self.motion.plan
        t = plan.nearest_stable(
            (self._followed - 1) * self._period, self.settings.balance.min_margin
        )
        sample = round(t / plan.period)
        phase = plan.phases[int(plan.phase_number[sample])].phase.name
        margin = float(plan.balance.static_margin[sample])
        return (
            f"the legs are held where they are at {t:.3f} s of the reference ({phase}); there "
            f"the centre of mass is {from_edge(margin)}"
        )

    def _end_of_motion(self) -> Vector | None:
        """See `ServoAxes`; the last sample is left when the loop's time is over.

        Rounding of times may leave one more.
        """
        if self.motion is None or not self._followed:
            return None
        if self._followed < len(self.motion.plan.t) - 2:
            return None
        return self._with_added(self.motion.at(self.motion.duration).positions)

    def row(
        self, state: LegsState, reference: LegsReference, command: LegsCommand, applied: LegsCommand
    ) -> tuple[float, ...]:
        """Return this cycle's values for `columns`."""
        planned = self.motion.sample(self._followed) if self.motion is not None else (0.0,) * 26
        if reference.follow:
            self._followed += 1
        joints = self.joint_row(state, reference, command, applied)
        felt = () if self._sensors is None else self._sensors.row((planned[3:6], planned[6:9]))
        return (*joints, *planned, *felt)
