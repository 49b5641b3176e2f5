"""The first motion, under the limits of a rig that was never commissioned."""

from rig.assembly import check_profile, make_controller, plan_motion
from rig.commissioning.derating import derated
from rig.commissioning.site import Site
from rig.commissioning.step import Defect, Measured, Outcome, Step, require_within
from rig.config import Experiment, ReferenceEntry
from rig.experiment.plan import Plan
from rig.experiment.run import run_experiment
from rig.run_facts import RunStatus
from rig.runtime.log import read_log
from rig.runtime.phases import Phase


class FirstMotion(Step):
    """A small motion under control.

    Parameters
    ----------
    kind, reference : str, object
        Name and settings of the reference.
    column, unit : str
        Of the log, where the motion is seen, and its SI unit.
    travel : float
        How far it goes, SI.
    """

    name = "first-motion"
    expects = "It goes as far as it is sent, and comes to rest."

    def __init__(self, kind: str, reference: object, column: str, unit: str, travel: float) -> None:
        self.does = f"The rig is energised and moves by {travel:g} {unit} under control."
        self._reference = ReferenceEntry(kind, reference)
        self._column = column
        self._unit = unit
        self._travel = travel

    def perform(self, site: Site) -> Outcome:
        """See `Step.perform`."""
        rig = site.make_rig()
        rig.close()
        result = run_experiment(
            self._plan(site), rig.backend, site.out, on=site.on, report=False,
            heed_calibrations=False,
        )  # fmt: skip
        if result.status is not RunStatus.OK:
            raise Defect("first motion", f"{result.status}: {result.message}")
        log = read_log(result.path / "log.mcap")
        shown = log.column(self._column)[log.column("phase") == Phase.RUN]
        went = float(shown.max() - shown.min())
        moved = Measured("moved by", went, self._unit, 0.5 * self._travel, 2.0 * self._travel)
        require_within("first motion", moved, "it does not go as far as it was sent")
        return Outcome((moved,), {"run": str(result.path)})

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
