"""The way from a page to the gains of a run that goes on."""

from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, cast

from controllers.base import Law, Tunable
from rig.assembly import REGISTRY, make_controller
from rig.config import Profile, load_profile
from rig.hal import ConfigurationError, RigError
from rig.hal.mechanism import ClosedLoop
from rig.run_folder import RunFolder
from rig.steering.mailbox import Mailbox
from rig.tuning.gains import values_of, with_gains
from rig.watching.messages import Request

if TYPE_CHECKING:
    from rig.watching.picture import Plain


class Steering:
    """Checks what a page asks for, and puts it where the loop looks once a cycle.

    The loop checks it again: it is the one that decides.

    Parameters
    ----------
    run : Path
        The run's folder.

    Raises
    ------
    ConfigurationError
        Its profile does not say which gains there are.
    """

    def __init__(self, run: Path) -> None:
        self._run = run
        self._box: Mailbox | None = None
        self._one_at_a_time = Lock()
        self._profile: Profile = load_profile(run / "profile.yaml", REGISTRY)
        self._law = str(RunFolder.open(run).manifest.get("law"))
        if self._law not in self._profile.controllers:
            raise ConfigurationError(f"{run}: its profile has no controller {self._law!r}")
        self._settings = self._profile.controllers[self._law]
        self._gains: tuple[Tunable, ...] = ()
        try:
            law = make_controller(self._profile, self._law)
        except RigError:
            return
        if isinstance(law, Law):
            self._gains = law.online

    def described(self) -> "list[Plain]":
        """Return what may be changed, its value, and within which bounds."""
        now = values_of(self._gains, self._settings) if self._gains else {}
        return [gain._asdict() | {"value": now[gain.key]} for gain in self._gains]

    def answer(self, request: Request) -> str | None:
        """Hand a change on, or say why not; a question ends with a question mark."""
        with self._one_at_a_time:  # of several pages
            return self._answer(request)

    def _answer(self, request: Request) -> str | None:
        try:
            box = self._opened()
        except (OSError, ValueError):
            return "this run was not started with --steer"
        if request["type"] == "hold":
            box.beat()
            return None
        key, value = str(request["key"]), cast("float", request["value"])
        known = [gain.key for gain in self._gains]
        if self._settings is None or key not in known:
            return f"{key} is no gain that may be changed while the run goes on"
        gain = self._gains[known.index(key)]
        if not gain.low <= value <= gain.high:
            return f"{key} has to be {gain.low:g} … {gain.high:g}"
        wanted = with_gains(self._settings, {key: float(value)})
        if not request["sure"] and (doubt := self._doubt(wanted)) is not None:
            return f"{doubt}; change {key} to {value:g} all the same?"
        box.post(known.index(key), float(value), cast("float", request["ramp"]))
        self._settings = wanted
        return f"{key}: {value:g} was asked for"

    def _opened(self) -> Mailbox:
        if self._box is None:
            self._box = Mailbox(self._run)
        return self._box

    def _doubt(self, settings: object) -> str | None:
        """Say if the loop would be less robust than process control asks for."""
        profile = self._profile
        view = REGISTRY.load("mechanism", profile.mechanism)
        law = type(make_controller(profile, self._law))
        try:
            model = view.model_of(profile.mechanism_settings)
            loop = view.closed_loop(
                profile.mechanism_settings, law(settings, model, profile.loop.period)
            )
        except (ConfigurationError, ValueError) as error:
            return str(error)
        if not isinstance(loop, ClosedLoop) or loop.is_robust:
            return None
        if not loop.stable:
            return "the loop would be stable by friction only"
        return f"the loop would have a sensitivity of {loop.sensitivity:.2g}, above 2"
