"""Who is on the buses and who should not be, and what of their settings was read back."""

from rig.assembly.survey import survey_rig
from rig.assembly.survey_words import differences_in_words, say_renumbered
from rig.commissioning.site import Site
from rig.commissioning.step import AcceptanceStep, Defect, MeasuredValue, StepResult


class OnTheBus(AcceptanceStep):
    """Everybody on the buses is asked who he is."""

    name = "bus"
    does = "Every node number of every bus is asked; nothing is configured or energised."
    expects = "Each device of the profile answers once, and nobody else does."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        answers = survey_rig(site.make_rig(site.profile))
        different = differences_in_words(answers)
        if different:
            # The first clause names its device as every defect does: "NAME (PLACE): WHAT".
            who, _, what = "; ".join(different).partition(": ")
            renumbered = say_renumbered(site.profile, answers)
            raise Defect(who, what if renumbered is None else f"{what}; {renumbered}")
        count = MeasuredValue("devices that answer", float(len(answers)), "1")
        return StepResult((count,), said="" if answers else "no bus of this rig can be asked")


class SettingsReadBack(AcceptanceStep):
    """Every device is connected: it says who it is, and keeps what is written to it."""

    name = "identity"
    does = "Each device is reset, identified and configured; each setting is read back."
    expects = "Types and serial numbers of the profile; every safety object keeps its value."

    def perform(self, site: Site) -> StepResult:
        """See `AcceptanceStep.perform`."""
        rig = site.make_rig(site.profile)
        with rig:
            identities = {name: dict(item.identity()) for name, item in rig.devices.items()}
            written = {name: dict(item.written()) for name, item in rig.devices.items()}
        count = sum(map(len, written.values()))
        return StepResult(
            (MeasuredValue("settings read back", float(count), "1"),),
            {"identities": identities, "written": written},
        )
