"""The first motion, under the limits of a rig that was never commissioned."""

from collections.abc import Sequence

import numpy as np

from rig.assembly import check_profile, make_controller, plan_motion
from rig.commissioning.derating import derated
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult, require_within
from rig.config import Experiment, ReferenceEntry
from rig.experiment.plan import Plan
from rig.experiment.run import run_experiment
from rig.run_facts import RunStatus
from rig.runtime.log import read_log
from rig.runtime.phases import Phase


class FirstMotion(AcceptanceStep):
    """A small motion under control.

    Parameters
    ----------
    kind, reference : str, object
        Name and settings of the reference.
    columns : sequence of str
        Of the log, where the motion is seen.
    travel, unit : float, str
        How far the one of them goes that goes furthest, and its SI unit.
    """

    name = "first-motion"
    expects = "It goes as far as it is sent, and comes to rest."

    def __init__(
        self, kind: str, reference: object, columns: Sequence[str], travel: float, unit: str
    ) -> None:
        self.does = f"The rig is energised and moves by {travel:g} {unit} under control."
        self._reference = ReferenceEntry(kind, reference)
        self._columns = columns
        self._unit = unit
        self._travel = travel

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        rig = site.make_rig()
        rig.close()
        result = run_experiment(
            self._plan(site), rig.backend, site.out, on=site.on, report=False,
            heed_calibrations=False,
        )  # fmt: skip
        if result.status is not RunStatus.OK:
            raise Defect("first motion", f"{result.status}: {result.message}")
        log = read_log(result.path / "log.mcap")
        runs = log.column("phase") == Phase.RUN
        went = max(float(np.ptp(log.column(name)[runs])) for name in self._columns)
        moved = MeasuredValue("moved by", went, self._unit, 0.5 * self._travel, 2.0 * self._travel)
        require_within("first motion", moved, "it does not go as far as it was sent")
        return StepResult((moved,), {"run": str(result.path)})

    def _plan(self, site: Site) -> Plan:
        profile = derated(site.profile)
        check_profile(profile)
        law = next(iter(profile.controllers))
        controller = make_controller(profile, law)
        motion = plan_motion(profile, self._reference.settings, controller)
        experiment = Experiment(
            name="commission-first-motion",
            description="the first motion of the acceptance test",
            rig=profile.name,
            controller=law,
            reference=self._reference,
            approach=5.0,
            metrics={},
            figures=(),
        )
        return Plan(experiment, profile, controller, motion)
