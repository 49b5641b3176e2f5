"""Whether what a procedure found can be laid over the profile: asked before a file is written."""

from collections.abc import Sequence

import yaml

from rig.calibration.procedure import Finding
from rig.config import Profile
from rig.config.calibration import lay_over
from rig.config.diagnostics import Problems, nearest
from rig.config.document import parse_mapping
from rig.config.dump import as_plain
from rig.config.located import Node, Source
from rig.config.quantities import UnitError, parse_unit
from rig.config.settings import build
from rig.hal import ContractBroken, RigError
from rig.hal.fits import fits, shown


def check_findings(procedure: object, findings: Sequence[Finding], profile: Profile) -> None:
    """Refuse findings of a wrong type or unit, and values that the profile's settings do not take.

    Parameters
    ----------
    procedure : Procedure
        Who found them.
    findings : sequence of Finding
        What it found.
    profile : Profile
        What they are laid over.

    Raises
    ------
    ContractBroken
        With the procedure's code, the target, and the value or unit.
    """
    kind = type(procedure)
    what = f"{kind.__module__}.{kind.__qualname__}.identify"
    if not fits(findings, Sequence[Finding]):
        raise ContractBroken(f"{what} returned {shown(findings)}, and no sequence of Finding")
    for finding in findings:
        for unit in (finding.unit, *(estimate.unit for estimate in finding.estimates)):
            try:
                parse_unit(unit)
            except UnitError as error:
                raise ContractBroken(f"{what}: {finding.target}: {error}") from error
        try:
            _lay_over(finding, profile)
        except (RigError, yaml.YAMLError) as error:
            raise ContractBroken(f"{what}: {finding.target}: {error}") from error


def _lay_over(finding: Finding, profile: Profile) -> None:
    """Lay the values over the settings as they are.

    Raises
    ------
    RigError
        They do not take them, or there are none.
    """
    known = {profile.mechanism: profile.mechanism_settings}
    known |= {name: entry.settings for name, entry in profile.devices.items()}
    if finding.target not in known:
        hint = nearest(finding.target, known)
        raise ContractBroken(f"the profile has no device or mechanism of this name; {hint}")
    settings, problems = known[finding.target], Problems()
    before = _located("the profile", as_plain(settings), problems)
    values = _located("the values", dict(finding.values), problems)
    build(type(settings), lay_over(before, values), problems)
    problems.raise_if_any()


def _located(name: str, plain: object, problems: Problems) -> Node:
    text = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    return parse_mapping(Source(name, text), problems)
