"""Answers in a file: in what form each is taken, and whether a file has what will be asked."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from rig.commissioning.forms import Form
from rig.config.diagnostics import nearest
from rig.hal import ConfigurationError

if TYPE_CHECKING:
    from rig.commissioning.questions import Rehearsed


def check_answers(
    path: object,
    given: Mapping[str, str],
    asked: "Rehearsed",
    lacking: Sequence[str] | None = None,
) -> None:
    """Refuse answers that no step asks for, or takes; and a file that lacks some.

    Parameters
    ----------
    path : Path
        The file, for the message.
    given : mapping
        Answers by their keys.
    asked : Rehearsed
        What is asked.
    lacking : sequence of str, optional
        The steps that are to be taken; default: all. Others have their answers already.

    Raises
    ------
    ConfigurationError
        With all that is wrong.
    """
    wrong = [text for key, answer in given.items() if (text := _problem(key, answer, asked))]
    missing: dict[str, None] = {}
    for question in asked.questions:
        if lacking is None or question.step in lacking:
            stem = asked.stem_of(question.key)
            if not (any(asked.stem_of(key) == stem for key in given) if stem
                    else question.key in given):  # fmt: skip
                missing[f"{stem}…" if stem else question.key] = None
    if missing:
        wrong.append(f"no answer to {', '.join(missing)}")
    if wrong:
        raise ConfigurationError(
            f"the file of answers {path}: {'; '.join(wrong)} (--dry-run shows what is asked)"
        )


def _problem(key: str, answer: str, asked: "Rehearsed") -> str:
    """Return what is wrong with an answer; empty: nothing that is known before it is asked."""
    form: Form | None = asked.form_of(key)
    if form is not None:
        said = form(answer)
        return f"{key} is {answer!r}, expected {said}" if said else ""
    if asked.stopped is not None:  # what is asked later is not known
        return ""
    near = nearest(key, [question.key for question in asked.questions])
    return f"{key!r} is never asked; {near or 'nothing is'}"
