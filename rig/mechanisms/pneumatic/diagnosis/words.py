"""Causes in words, with what the profile says where it says something."""

from rig.hal.hindsight import Suspect
from rig.mechanisms.pneumatic.diagnosis.causes import Explanation
from rig.mechanisms.pneumatic.diagnosis.evidence import LastSecond
from rig.mechanisms.pneumatic.diagnosis.forces import FRICTION, PULL
from rig.mechanisms.pneumatic.diagnosis.pressures import LEAK, MONITOR, OPEN, STUCK, SUPPLY
from rig.mechanisms.pneumatic.diagnosis.regulators import LATE, SLOW

WIRE, SLIP = "wire", "slip"
"""Causes that a mechanism with more wires than ways to move finds itself."""
_UNITS = {SLOW: "rad/s", LATE: "s", FRICTION: "", WIRE: "N/m", SLIP: "m"}
"""Of figures that are no pressures."""


def suspect_of(trial: Explanation, evidence: LastSecond) -> Suspect:
    """Return a cause as it is told."""
    of = "" if trial.channel is None else evidence.names[trial.channel]
    unit = _UNITS.get(trial.cause, "Pa")
    sentence = _sentence(trial, evidence, of)
    return Suspect(trial.cause, of, trial.figure, unit, round(trial.gain, 1), sentence)


def _sentence(trial: Explanation, evidence: LastSecond, of: str) -> str:
    response, figure, kilo = evidence.response, trial.figure, 1e-3 * trial.figure
    whose = f"regulator of {of}" if of else "all regulators"
    less = "more" if figure > 0.0 else "less"
    longer = "longer" if figure > 0.0 else "shorter"
    pair = next((p for p in evidence.pairs if trial.channel in p), ())
    names = " and ".join(evidence.names[k] for k in pair)
    return {
        SLOW: f"{whose}: the profile says {response.bandwidth:.3g} rad/s, I see {figure:.3g} rad/s",
        LATE: f"{whose}: the profile says {response.dead_time * 1e3:.3g} ms of dead time, I see "
        f"{figure * 1e3:.3g} ms",
        STUCK: f"{whose}: it is stuck at {kilo:.0f} kPa",
        OPEN: f"{whose}: it is stuck open",
        LEAK: f"chamber of {of}: it leaks, its tube is off or its regulator vents; it gets to "
        f"{kilo:.0f} kPa",
        SUPPLY: f"supply: no chamber gets beyond {kilo:.0f} kPa",
        MONITOR: f"monitor of {of}: it says {abs(kilo):.0f} kPa {less} than it should",
        WIRE: f"wires: the profile says {evidence.settings.wire_stiffness * 1e-3:.3g} N/mm, I see "
        f"{kilo:.3g} N/mm",
        SLIP: f"wire of {of}: it is {abs(figure) * 1e3:.2g} mm {longer} than the others say, or "
        "its encoder is off",
        FRICTION: f"friction of {names}: {figure:.2g} times what the profile says",
        PULL: f"chamber of {of}: it pulls as with {kilo:.0f} kPa less than its monitor says; it "
        "leaks behind its tube, or the monitor is off",
    }[trial.cause]
