"""The file that puts gains in force: laid over a controller's settings as a calibration is."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from importlib import metadata
from pathlib import Path

from rig.calibration.basis import basis_of_gains
from rig.calibration.store import in_force, write
from rig.config.calibration import STATED
from rig.config.laid_over import TUNED
from rig.config.ownership import owner_label
from rig.sweeping.code import code_version
from rig.tuning.gains import nested
from rig.tuning.verdict import EnsembleVerdict
from rig.tuning.workbench import Request, Workbench

_COMMAND = "tune"
_HOLDS = 365.0
"""Days after which gains should be looked at again."""


def put_in_force(
    bench: Workbench,
    request: Request,
    verdict: EnsembleVerdict,
    *,
    search: Sequence[Path],
    operator: str,
    facts: Mapping[str, str],
) -> Path:
    """Write gains to ``calibration/RIG/controllers.LAW.yaml``; the older file is kept.

    Parameters
    ----------
    bench, request
        What was tuned.
    verdict : EnsembleVerdict
        The gains, and what they came to.
    search : sequence of Path
        The folders of configurations; the file is written into the first.
    operator : str
        Who tuned.
    facts : mapping of str to str
        What else is worth knowing of the search.

    Raises
    ------
    ConfigurationError
        It cannot be written.
    """
    target = f"{TUNED}{request.controller}"
    now = datetime.now(UTC)
    old = in_force(bench.profile, search, target)
    provenance = {
        "procedure": _COMMAND,
        "date": now.isoformat(timespec="seconds"),
        "operator": operator,
        "backend": _origin(bench),
        "seed": request.seed,
        "profile": owner_label(bench.profile.files, search),
        "parent": None if old is None else old["provenance"]["date"],
        "valid_until": (now + timedelta(days=_HOLDS)).date().isoformat(),
        "software": f"rig-controller {metadata.version('rig-controller')}",
        "conditions": {**facts, "code": code_version().digest, **_figures(bench, verdict)},
        "basis": {_COMMAND: basis_of_gains(bench.profile)},
    }
    content = {
        "values": nested(verdict.gains),
        "measured": [_measured(name, gain) for name, gain in verdict.gains.items()],
        "provenance": {key: value for key, value in provenance.items() if value is not None},
    }
    return write(search[0], bench.profile.name, target, content, _COMMAND)


def _origin(bench: Workbench) -> str | None:
    """Return where what the gains rest on was measured."""
    calibration = bench.profile.calibration
    return STATED if calibration is None else calibration.provenance.backend


def _figures(bench: Workbench, verdict: EnsembleVerdict) -> dict[str, str]:
    bounds = {f"ensemble, {name}": text for name, text in bench.ensemble.ranges().items()}
    errors = {}
    for stretch, error in verdict.nominal.errors.items():
        worst, member = verdict.worst(stretch)
        errors[f"error, {stretch}"] = (
            f"{1e3 * error:.3f} mm rms; worst {1e3 * worst:.3f} mm ({member.name or 'as told'})"
        )
    return {
        **bounds,
        **errors,
        "hunting": f"{1e3 * verdict.hunting:.3f} mm",
        "reversals": f"{verdict.reversals:.1f} a second",
        "lost plants": f"{len(verdict.lost)} of {len(verdict.trials)}",
        "sensitivity kept": f"{100 * verdict.robust:.1f} % of {len(verdict.margins)} plants, "
        + ("" if verdict.told == len(verdict.margins) else f"{verdict.told} of them told, ")
        + ("measured" if verdict.measured else "by the linear model"),
        "cost": f"{verdict.cost:.3f}",
    }


def _measured(name: str, gain: float) -> dict[str, object]:
    return {"name": name, "value": gain, "unit": "", "std": 0.0, "interval": [gain, gain],
            "procedure": _COMMAND}  # fmt: skip
