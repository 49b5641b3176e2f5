"""Wake-ups of the computer and load of the buses."""

from rig.assembly.buses import bus_loads
from rig.commissioning.bench import StepBench
from rig.commissioning.lost_frames import BRIEFLY, lost_frames
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, MeasuredValue, StepResult, require_within

_WATCHED = 1.0
"""How long the cycle is watched, s."""


class Load(AcceptanceStep):
    """The cycle runs for a second, armed and without setpoints."""

    name = "load"
    does = "The cycle runs for a second at the loop's rate; nothing is asked to move."
    expects = "Every bus is within its load, next to no frame is lost, and cycles come in time."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        profile = site.profile
        measured = [
            MeasuredValue(f"load of the bus {name}", load.total, "1")
            for name, load in bus_loads(profile).items()
        ]
        rig = site.make_rig(site.profile)
        with rig:
            rig.arm(torque=False)
            bench, late = StepBench(rig), 0.0
            end = bench.now + _WATCHED
            while bench.now < end:
                start = bench.now
                bench.cycle()
                late = max(late, bench.now - start - profile.loop.period)
            counted = rig.statistics()
        for name, counts in counted.items():
            lost = lost_frames("", name, counts, BRIEFLY)
            measured.append(require_within(name, lost, "frames are lost"))
        most = profile.loop.max_missed * profile.loop.period
        # Differences of virtual times are rounded by less than a nanosecond.
        latest = MeasuredValue("latest cycle", round(late, 9), "s", high=most)
        measured.append(require_within("computer", latest, "cycles come too late"))
        return StepResult(tuple(measured))
