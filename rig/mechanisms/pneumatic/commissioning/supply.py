"""Supply valve and dump: no air without it, and none left when it shuts."""

from rig.commissioning.site import Site
from rig.commissioning.step import (
    AcceptanceStep,
    MeasuredValue,
    StepResult,
    require,
    require_within,
)
from rig.mechanisms.pneumatic.commissioning.chambers import SEEN, energised
from rig.mechanisms.pneumatic.commissioning.spool import overshoot_of


class SupplyAndDump(AcceptanceStep):
    """The supply valve is kept shut, opened, and shut again, with setpoints that stay."""

    name = "supply"
    does = (
        "Every chamber is asked for 5 to 17 kPa above the least setpoint with the supply shut, "
        "open, and shut again; a chamber on a valve then goes from 4 to 9 kPa, alone."
    )
    expects = "Pressure comes with the supply alone, and leaves by the dump valve when it shuts."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        most = site.profile.loop.safe_within
        with energised(site, supply=False) as chambers:
            regulators, bench = chambers.regulators, chambers.bench
            if not regulators.shut_supply(True):
                return StepResult(said="the profile names no supply valve")
            leaking = max(chambers.climb().rises)
            require(
                leaking < SEEN, "supply valve",
                f"pressure rises by {leaking / 1e3:.1f} kPa while it is shut: it does not shut",
            )  # fmt: skip
            regulators.shut_supply(False)
            rises = chambers.climb().rises
            chambers.require_answers(rises)
            regulators.shut_supply(True)
            start, fallen = bench.now, chambers.have_fallen(0.5, rises)
            while not fallen() and bench.now - start <= most:
                bench.cycle()
            took = MeasuredValue(
                "vented by the dump valve after", bench.now - start, "s", high=most
            )
        require_within(
            "dump valve", took, "the chambers keep their pressure when the supply is shut: there "
            "is no dump valve, or it sticks",
        )  # fmt: skip
        measured = [took]
        if site.profile.mechanism_settings.valves is not None:
            channels = range(len(regulators.channels))
            measured += [overshoot_of(site, number) for number in channels]
        return StepResult(tuple(measured))
