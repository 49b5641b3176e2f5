"""The way from a page to the gains of a run that goes on."""

from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, cast

from controllers.base import Law
from rig.assembly import REGISTRY, controller_class
from rig.config import load_profile
from rig.hal import ConfigurationError
from rig.hal.closed_loop import ClosedLoop
from rig.run_folder import RunFolder
from rig.steering.mailbox import Mailbox
from rig.tuning.gains import values_of, widened, with_gains
from rig.watching.messages import Request

if TYPE_CHECKING:
    from rig.watching.picture import Plain


class Steering:
    """Checks what a page asks for, and puts it where the loop looks once a cycle.

    The loop checks it again: it is the one that decides, and what it says is in the run's events.
    Nothing is compiled here: bounds are the class's, and margins need no law that is fast.

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
        self._folder = RunFolder.open(run)
        self._box: Mailbox | None = None
        self._one_at_a_time = Lock()
        self._profile = load_profile(run / "profile.yaml", REGISTRY)
        name = str(self._folder.manifest.get("law"))
        self._kind = kind = controller_class(self._profile, name)
        self._first = first = self._profile.controllers[name]
        online = kind.online if isinstance(kind, type) and issubclass(kind, Law) else ()
        self._gains = widened(online, first)

    def described(self) -> "list[Plain]":
        """Return what may be changed, its value, and within which bounds."""
        now = values_of(self._gains, with_gains(self._first, self._changed()))
        return [gain._asdict() | {"value": now[gain.key]} for gain in self._gains]

    def answer(self, request: Request) -> str | None:
        """Hand a change on, or say why not; a question ends with a question mark."""
        try:
            box = self._box = self._box or Mailbox(self._run)
        except (OSError, ValueError):
            return "this run was not started with --steer"
        if request["type"] == "hold":
            box.beat()
            return None
        with self._one_at_a_time:  # of several pages
            return self._answer(request, box)

    def _answer(self, request: Request, box: Mailbox) -> str:
        key, value = str(request["key"]), float(cast("float", request["value"]))
        known = [gain.key for gain in self._gains]
        if key not in known:
            return f"{key} is no gain that may be changed while the run goes on"
        gain = self._gains[known.index(key)]
        if not gain.low <= value <= gain.high:
            return f"{key} has to be {gain.low:g} … {gain.high:g}"
        doubt = None if request["sure"] else self._doubt(self._changed() | {key: value})
        if doubt is not None:
            return f"{doubt}; change {key} to {value:g} all the same?"
        box.post(known.index(key), value, cast("float", request["ramp"]))
        return f"{key}: {value:g} was asked for"

    def _changed(self) -> dict[str, float]:
        """Return the gains that the loop has changed, as the run's events tell."""
        known = {gain.key for gain in self._gains}
        told = [
            event.get("data", {})
            for event in self._folder.events()
            if event.get("kind") == "tuning"
        ]
        return {
            str(data["key"]): float(cast("float", data["new"]))
            for data in told
            if data.get("accepted") and data.get("key") in known
        }

    def _doubt(self, gains: dict[str, float]) -> str | None:
        """Say if the loop would be less robust than process control asks for."""
        profile = self._profile
        view = REGISTRY.load("mechanism", profile.mechanism)
        try:
            model = view.model_of(profile.mechanism_settings)
            law = self._kind(with_gains(self._first, gains), model, profile.loop.period)
            loop = view.closed_loop(profile.mechanism_settings, law)
        except (ConfigurationError, ValueError) as error:
            return str(error)
        if not isinstance(loop, ClosedLoop) or loop.is_robust:
            return None
        if not loop.stable:
            return "the loop would be stable by friction only"
        return f"the loop would have a sensitivity of {loop.sensitivity:.2g}, above 2"
