"""The contact of the emergency stop, without energy: press, release, wire off."""

from collections.abc import Callable
from functools import partial

from rig.assembly import Rig
from rig.commissioning.operator import Task
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, MeasuredValue, StepResult, require
from rig.hal.world import BreakableWorld

_LOOK = 5e-3
"""Between two looks at the contact, s."""


def stop_task(device: str, key: str, text: str, fault: str, value: float) -> Task:
    """Return what a hand does to the emergency stop."""

    def act(world: BreakableWorld) -> str:
        world.inject(device, fault, value)
        return "done"

    return Task(f"emergency-stop.{key}", text, act)


def stop_device(rig: Rig) -> str | None:
    """Return the name of the device that reads the emergency stop; None: the rig has none."""
    stop: object = rig.mechanism.stop_input()
    return next((name for name, device in rig.devices.items() if device is stop), None)


class EmergencyStopContact(AcceptanceStep):
    """The contact is seen pressed, released and cut."""

    name = "emergency-stop"
    does = "You press and release the emergency stop and take its wire off; nothing is energised."
    expects = "Each is seen. A wire that is off reads as pressed: the contact is normally closed."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        rig = site.make_rig(site.profile)
        device = stop_device(rig)
        if device is None:
            return StepResult(said="the profile names no contact of an emergency stop")
        times = []
        with rig.watching_stop() as is_pressed:
            require(
                self._wait(site, rig, is_pressed, False),
                "emergency stop",
                "it reads pressed while it is not: the contact is normally open, or its wire is "
                "off, or stop_active_low is wrong",
            )
            for key, text, fault, value, pressed, defect in (
                ("press", "Press the emergency stop.", "emergency_stop", 1.0, True,
                 "it was pressed and is not seen: the contact is not wired to this input"),
                ("release", "Release the emergency stop.", "emergency_stop", 0.0, False,
                 "it was released and still reads pressed: the contact sticks"),
                ("wire-off", "Take the wire of the emergency stop off.", "stop_wire_off", 1.0, True,
                 "its wire is off and it reads released: the contact is normally open, so that a "
                 "broken wire would never be seen"),
                ("wire-on", "Put the wire of the emergency stop back.", "stop_wire_off", 0.0, False,
                 "its wire is back and it still reads pressed"),
            ):  # fmt: skip
                site.operator.do(stop_task(device, key, text, fault, value), site.world_of(rig))
                before = rig.clock.now()
                require(self._wait(site, rig, is_pressed, pressed), "emergency stop", defect)
                times.append(MeasuredValue(f"{key} seen after", rig.clock.now() - before, "s"))
        return StepResult(tuple(times))

    def _wait(
        self, site: Site, rig: Rig, is_pressed: Callable[[], bool | None], wanted: bool
    ) -> bool:
        end = rig.clock.now() + site.patience(rig)
        while is_pressed() is not wanted:
            if rig.clock.now() >= end:
                return False
            rig.clock.sleep_until(rig.clock.now() + _LOOK)
        return True


press = partial(
    stop_task, key="press-energised", text="Press the emergency stop.", fault="emergency_stop",
    value=1.0,
)  # fmt: skip
release = partial(
    stop_task, key="release-energised", text="Release the emergency stop.",
    fault="emergency_stop", value=0.0,
)  # fmt: skip
