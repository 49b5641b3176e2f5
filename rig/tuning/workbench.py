"""The bench of one rig and law, as a request names it: made once in each process."""

import json
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

from controllers.base import AnyLaw, Law, Tunable
from rig.assembly import REGISTRY, check_profile, controller_class
from rig.assembly.simulated import lend_plant
from rig.config import Profile, load_profile
from rig.config.names import find_configs
from rig.experiment.plan import load_plan
from rig.hal import ConfigurationError
from rig.hal.bench import Trial, TuningBench
from rig.hal.closed_loop import ClosedLoop
from rig.tuning.ensemble import NOISIER, Ensemble, Member
from rig.tuning.gains import with_gains

COARSE = 0.1e-3
"""Substep of the search, s: twice as fast as the plant's own, which has the last word."""


class Request(NamedTuple):
    """The wish of who tunes.

    Parameters
    ----------
    rig : str
        A profile's name or path.
    controller : str
        Its law.
    experiment : str or None
        Whose motion it is tuned for; None: the mechanism's usual ones.
    overrides : tuple of str
        Settings, as for ``--set``.
    configs : str or None
        The folder of the configurations.
    seed : int
        Of the ensemble and of the search.
    """

    rig: str
    controller: str
    experiment: str | None
    overrides: tuple[str, ...]
    configs: str | None
    seed: int

    def text(self) -> str:
        """Return it as text, from which `of_text` makes it again."""
        return json.dumps(self)

    @classmethod
    def of_text(cls, text: str) -> "Request":
        """Return a request from its text."""
        rig, controller, experiment, overrides, configs, seed = json.loads(text)
        return cls(rig, controller, experiment, tuple(overrides), configs, seed)


class Workbench:
    """A rig's bench with what it takes to judge gains on it.

    Parameters
    ----------
    request : Request
        What is tuned.

    Raises
    ------
    ConfigurationError
        There is no such rig, law or experiment, or nothing to tune.
    """

    def __init__(self, request: Request) -> None:
        self.profile, self._motions = _loaded(request)
        self.law = _law(self.profile, request.controller)
        self.tunables: tuple[Tunable, ...] = self.law.tunables
        self.settings = self.profile.controllers[request.controller]
        self._fine, self._coarse = self._bench(None), self._bench(COARSE)
        self._noisy = {True: self._bench(COARSE, NOISIER), False: self._bench(None, NOISIER)}
        try:
            self._fine.check(self.settings)
        except ValueError as error:
            where = f"{self.profile.name}: controllers.{request.controller}"
            raise ConfigurationError(f"{where}: {error}") from error
        self.unit = self._fine.unit
        self.duration = self._fine.duration
        calibration = self.profile.calibration
        replaced = calibration.replaced if calibration is not None else {}
        measured = replaced if isinstance(replaced, dict) else {}
        self.ensemble = Ensemble(self._fine.told(), self._fine.unknowns, measured, request.seed)

    def trial(self, gains: Mapping[str, float], member: Member, *, coarse: bool) -> Trial:
        """Run the law with some gains on one plant."""
        bench = self._coarse if coarse else self._fine
        if member.noisy:
            bench = self._noisy[coarse]
        chosen = with_gains(self.settings, gains)
        return bench.trial(chosen, member.numbers, member.seed)

    def margins(self, gains: Mapping[str, float], members: list[Member]) -> list[ClosedLoop]:
        """Return the margins around plants."""
        chosen = with_gains(self.settings, gains)
        return list(self._fine.margins(chosen, [member.numbers for member in members]))

    def measured(
        self, gains: Mapping[str, float], members: Sequence[Member]
    ) -> list[ClosedLoop] | None:
        """Return the margins that are measured on plants that are shaken; None: nothing does."""
        chosen = with_gains(self.settings, gains)
        found = self._coarse.measured(chosen, [(member.numbers, member.seed) for member in members])
        return None if found is None else list(found)

    def _bench(self, substep: float | None, noisier: float = 1.0) -> TuningBench:
        kind = REGISTRY.bench(self.profile.mechanism)
        if kind is None:
            raise ConfigurationError(
                f"a {self.profile.mechanism} cannot be tuned: its row names no bench"
            )
        lend = partial(lend_plant, self.profile, substep=substep, noisier=noisier)
        return kind(
            self.profile.mechanism_settings, self.law, self.profile.loop.period, lend,
            self._motions,
        )  # fmt: skip


@cache
def workbench_of(text: str) -> Workbench:
    """Return the bench of a request's text, made once."""
    return Workbench(Request.of_text(text))


def _loaded(request: Request) -> tuple[Profile, tuple[object, ...]]:
    """Return the profile, and the motions that it is tuned for if somebody says."""
    configs = None if request.configs is None else Path(request.configs)
    if request.experiment is None:
        search = find_configs(configs)
        profile = load_profile(request.rig, REGISTRY, request.overrides, search)
        check_profile(profile)
        return profile, ()
    plan = load_plan(request.experiment, request.overrides, rig=request.rig, configs=configs)
    return plan.profile, (plan.motion,)


def _law(profile: Profile, controller: str) -> type[AnyLaw]:
    law = controller_class(profile, controller)
    if not (isinstance(law, type) and issubclass(law, Law) and law.tunables):
        raise ConfigurationError(
            f"the law {controller} does not say what of it may be tuned: give its class "
            "`tunables`, a tuple of controllers.base.Tunable(key, low, high), as "
            "controllers/cylinder/pid.py does"
        )
    return law
