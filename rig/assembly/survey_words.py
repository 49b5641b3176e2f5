"""What a survey of buses found that a profile does not say, in words."""

from collections.abc import Sequence

from rig.assembly.survey import Answer, contradictions, expected_on
from rig.config import Profile


def differences_in_words(answers: Sequence[Answer]) -> list[str]:
    """Return a clause for each answer that is not as the profile says, in their order."""
    return [
        f"{answer.name or 'an unknown device'} ({_where(answer)}): {', '.join(answer.differences)}"
        for answer in answers
        if answer.differences
    ]


def say_renumbered(profile: Profile, answers: Sequence[Answer]) -> str | None:
    """Say that the one missing device may be the one unknown one.

    None: more than one is missing or unknown, they are on two buses, or the unknown one says that
    it is something else.

    Parameters
    ----------
    profile : Profile
        Whose buses were asked.
    answers : sequence of Answer
        All of the survey.
    """
    missing = [answer for answer in answers if answer.name and answer.found is None]
    unknown = [answer for answer in answers if not answer.name]
    if len(missing) != 1 or len(unknown) != 1:
        return None
    (lost,), (other,) = missing, unknown
    found = other.found
    # Who only sends has not said what he is; several with one number are nobody in particular.
    if lost.bus != other.bus or found is None or found.answers != 1 or len(found.serials) > 1:
        return None
    expected = next(item for item in expected_on(profile, lost.bus) if item.name == lost.name)
    if contradictions(expected, found):
        return None
    return (
        f"node 0x{other.node:02X} may be {lost.name} with another node number: give it "
        f"0x{lost.node:02X}, or correct the profile"
    )


def _where(answer: Answer) -> str:
    return f"bus {answer.bus}, node 0x{answer.node:02X}"
