"""Whether chambers are empty whose monitors have been seen to lie."""

from collections.abc import Sequence

from rig.hal.devices import VENTED
from rig.mechanisms.pneumatic.alarms.pressures import PressureWatch


def explain_left(
    watch: PressureWatch, shown: Sequence[float], safe: Sequence[float], now: float
) -> str:
    """Follow the monitors in a cycle of the safe stop; return which may hide what is left.

    A monitor that has jumped down since air came on, in the run or in the stop until now, says of a
    full chamber that it is empty. So what it says is taken without the jump.

    Parameters
    ----------
    watch : PressureWatch
        What followed the monitors until the stop.
    shown, safe : sequence of float
        What the monitors say, and the setpoints of the safe state, Pa gauge, shape (n,).
    now : float
        s.

    Returns
    -------
    str
        Empty: none hides more than a vented chamber may hold.
    """
    watch.follow_stop(shown, safe, now)
    found = []
    for name, here, jump, rest in zip(watch.names, shown, watch.jumps, safe, strict=True):
        says = f"its monitor says {1e-3 * here:.1f} kPa"
        hidden = max(-jump, 0.0)
        if hidden and here + hidden - rest > VENTED:
            found.append(
                f"{name} still holds {1e-3 * (here + hidden):.1f} kPa: {says}, but has jumped by "
                f"{1e-3 * jump:+.0f} kPa"
            )
        elif here + hidden < -VENTED:
            found.append(f"{name} still holds nobody knows what: {says}, as no chamber can")
    return f"{watch.device}: {', '.join(found)}" if found else ""
