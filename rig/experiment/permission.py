"""Whether a plan may be carried out where it is to be: asked before anything is opened."""

from datetime import UTC, datetime

from rig.assembly import Backend
from rig.config.calibration_state import calibration_states
from rig.experiment.fault_latch import FaultLatch
from rig.experiment.plan import Plan
from rig.hal import DeviceError


def check_permitted(
    plan: Plan, backend: Backend, on: str | None = None, *, heed_calibrations: bool = True
) -> list[str]:
    """Return what is doubtful in a simulation; on hardware it is refused.

    `on` names other interfaces than the profile's.

    Raises
    ------
    DeviceError
        On hardware: a fault is latched, or a calibration does not hold.
    """
    if backend is Backend.HARDWARE:
        FaultLatch.of(plan.profile, on).check()
    doubts: list[str] = []
    if not heed_calibrations:
        return doubts
    today = datetime.now(UTC).date()
    on_hardware = backend is Backend.HARDWARE
    for state in calibration_states(plan.profile, today, on_hardware=on_hardware):
        if state.problems and backend is Backend.HARDWARE:
            raise DeviceError(state.name, state.sentence)
        if state.problems:
            doubts.append(f"{state.name}: {state.sentence}")
    return doubts
