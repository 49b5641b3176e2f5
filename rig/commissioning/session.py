"""The acceptance test from its first step to its record, resumable."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

from rig.assembly import REGISTRY
from rig.commissioning.page import write_page
from rig.commissioning.record import (
    BY,
    Content,
    digest_of,
    load_record,
    missing,
    new_record,
    operator_of,
    tested_settings,
    whose,
    write_record,
)
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, MeasuredValue, StepResult
from rig.config import Profile
from rig.hal import ConfigurationError, RigError

Say = Callable[[str], None]


class CommissioningFacts(NamedTuple):
    """Facts about a test that only its operator knows.

    Parameters
    ----------
    backend : str
        On what.
    operator : str or None
        Who; None: the user.
    days : int
        How long it holds.
    """

    backend: str
    operator: str | None = None
    days: int = 365


def steps_of(profile: Profile) -> Sequence[AcceptanceStep]:
    """Return the steps of a rig's acceptance test, in their order.

    Raises
    ------
    ConfigurationError
        Its mechanism has none.
    """
    steps = REGISTRY.commissioning(profile.mechanism, AcceptanceStep)
    if not steps:
        raise ConfigurationError(
            f"{profile.name}: there is no acceptance test of a {profile.mechanism}; name one in "
            "the mechanism's row (MechanismParts.commissioning)"
        )
    return steps


def has_steps(profile: Profile) -> bool:
    """Return whether there is an acceptance test of a rig."""
    return bool(REGISTRY.commissioning(profile.mechanism, AcceptanceStep))


def begin(
    profile: Profile, search: Sequence[Path], circumstances: CommissioningFacts, *, anew: bool
) -> Content:
    """Return the record to go on with: the kept one, if it is of this rig as it is.

    Raises
    ------
    ConfigurationError
        The record of its name is another rig's, and not to be begun anew.
    """
    kept = None if anew else load_record(profile.name, search)
    other = whose(profile, kept, search)
    if other:
        raise ConfigurationError(
            f"the record of the commissioning of {profile.name} belongs to another rig: {other}; "
            "give this profile a name of its own with name: NAME, or write over it with --anew"
        )
    until = datetime.now(UTC).date() + timedelta(days=circumstances.days)
    new = new_record(
        profile, circumstances.backend, circumstances.operator, until.isoformat(), search
    )
    same = ("backend", "seed", "host", "settings", "program")
    # A record of before computers were named is taken as of this one.
    if kept is None or any(kept.get(key, new.get(key)) != new.get(key) for key in same):
        return new
    return dict(kept)


def commission(
    site: Site,
    record: Content,
    steps: Sequence[AcceptanceStep],
    configs: Path,
    say: Say,
    operator: str | None = None,
) -> str | None:
    """Take every step that the record lacks; return what stopped it, or None.

    The record is written after each step, and the page after the last one. Each step keeps who
    has taken it: another one than `operator` may have taken those before.
    """
    by = operator_of(operator)
    names = [step.name for step in steps]
    lacking = missing(record, names)
    for number, step in enumerate(steps, 1):
        if step.name not in lacking:
            continue
        say(f"{number}/{len(steps)} {step.name}: {step.does}")
        say(f"  expected: {step.expects}")
        found, defect = _perform(step, site, by)
        record["steps"][step.name] = found
        record["digest"] = ""
        for line in found["measured_in_words"]:
            say(f"  measured: {line}")
        if defect is not None:
            say(f"  FAILED: {defect}")
            write_record(configs, record)
            return f"{step.name}: {defect}"
        say(f"  passed{': ' + found['said'] if found['said'] else ''}")
        if step.name == names[-1]:
            record["digest"] = digest_of(tested_settings(site.profile), record["steps"])
        write_record(configs, record)
    write_page(configs, record, steps)
    return None


def _perform(step: AcceptanceStep, site: Site, by: str) -> tuple[Content, str | None]:
    try:
        outcome, defect = step.perform(site), None
    except RigError as error:
        if isinstance(error, ConfigurationError):
            raise
        outcome, defect = StepResult(said=str(error)), str(error)
    found = {
        "passed": defect is None,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        BY: by,
        "said": outcome.said,
        "measured": [_plain(value) for value in outcome.measured],
        "measured_in_words": [str(value) for value in outcome.measured],
        "facts": dict(outcome.facts),
    }
    return found, defect


def _plain(value: MeasuredValue) -> Content:
    """Return a value with its bounds; one that is infinite is no bound."""
    bounds = {"low": value.low, "high": value.high}
    finite = {name: bound for name, bound in bounds.items() if abs(bound) < float("inf")}
    return {"name": value.name, "value": float(value.value), "unit": value.unit, **finite}
