"""The faults that a profile has scheduled in its simulated world, as events of the run."""

from collections.abc import Iterator, Mapping, Sequence

from rig.config.simulation_models import FaultSpec
from rig.hal.world import BY_CHANNEL


def faults_that_came(
    faults: Sequence[FaultSpec],
    channels: Mapping[str, Sequence[str]],
    started: float,
    lasted: float,
) -> Iterator[tuple[float, str, dict[str, object]]]:
    """Return what broke by the end of a run: when on the log's clock, a sentence, and its data.

    Parameters
    ----------
    faults : sequence of FaultSpec
        Of the profile, on the clock of its world.
    channels : mapping
        Names of the channels of each device, and of the plant.
    started : float
        When the log's clock began, s on that of the world.
    lasted : float
        The log's last instant, s.
    """
    for fault in sorted(faults, key=lambda fault: fault.at):
        t = fault.at - started
        if t <= lasted:
            data: dict[str, object] = {
                "fault": fault.fault,
                "where": fault.device,
                "magnitude": fault.size,
            }
            channel = _channel_of(fault, channels.get(fault.device, ()))
            if channel is not None:
                data["channel"] = channel
                size = f", {channel} (value {fault.size or 0.0:g}: channels count from 0)"
            else:
                size = "" if fault.size is None else f", {fault.size:g}"
            sentence = f"simulation.faults: {fault.fault} of {fault.device}{size}"
            yield t, sentence, data


def faults_that_never_came(
    faults: Sequence[FaultSpec], started: float, lasted: float
) -> Iterator[str]:
    """Yield what was to break after a run was over; parameters as `faults_that_came`."""
    for fault in sorted(faults, key=lambda fault: fault.at):
        if fault.at - started > lasted:
            yield (
                f"simulation.faults: {fault.fault} of {fault.device} never came: it was for "
                f"{fault.at:.3g} s on the clock of the simulated world, which stood at "
                f"{started + lasted:.3g} s when the run was over"
            )


def _channel_of(fault: FaultSpec, names: Sequence[str]) -> str | None:
    """Return the channel that a fault's value means; None: the value is how much."""
    number = 0.0 if fault.size is None else fault.size
    if fault.fault not in BY_CHANNEL or number not in range(len(names)):
        return None
    return names[int(number)]
