"""The faults that a profile has scheduled in its simulated world, as events of the run."""

from collections.abc import Iterator, Sequence

from rig.config.simulation_models import FaultSpec


def faults_that_came(
    faults: Sequence[FaultSpec], started: float, lasted: float
) -> Iterator[tuple[float, str, dict[str, object]]]:
    """Return what broke by the end of a run: when on the log's clock, a sentence, and its data.

    Parameters
    ----------
    faults : sequence of FaultSpec
        Of the profile, on the clock of its world.
    started : float
        When the log's clock began, s on that of the world.
    lasted : float
        The log's last instant, s.
    """
    for fault in sorted(faults, key=lambda fault: fault.at):
        t = fault.at - started
        if t <= lasted:
            size = "" if fault.size is None else f", {fault.size:g}"
            sentence = f"simulation.faults: {fault.fault} of {fault.device}{size}"
            data: dict[str, object] = {
                "fault": fault.fault,
                "where": fault.device,
                "magnitude": fault.size,
            }
            yield t, sentence, data
