"""An experiment or a rig to begin with: one file, with a comment for what a reader asks first."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rig.assembly import REGISTRY
from rig.assembly.same_geometry import shared_lengths
from rig.config import Profile, load_profile
from rig.config.diagnostics import Problems
from rig.config.document import load_document
from rig.config.experiment import rig_of
from rig.config.names import find_file, list_files
from rig.config.plain_dump import plain_text
from rig.config.yaml_loader import read_source
from rig.hal import ConfigurationError

_RIG: Final = re.compile(r"^rig:[ ]*[^ \n]+(.*)$", re.MULTILINE)
_OWN: Final = re.compile(r"^(name|description):.*\n", re.MULTILINE)
_PLANT: Final = re.compile(r"^plant:.*(\n[ #].*)*", re.MULTILINE)


def experiment_text(
    name: str, rig: str | None, search: Sequence[Path], like: str | None = None
) -> str:
    """Return an experiment that runs at once: one of a rig's, under another name.

    Parameters
    ----------
    name : str
        Its name.
    rig : str, optional
        Whose it is; default: `cylinder`, or whose the one is that it begins with.
    search : sequence of Path
        Folders of configurations.
    like : str, optional
        The experiment to begin with; default: the first of the rig.

    Raises
    ------
    ConfigurationError
        There is no such experiment, or none of the rig.
    """
    if like is None:
        rig = rig or "cylinder"
        like = _first_of(rig, search)
    elif rig is not None:
        find_file(rig, "rigs", search)  # a name that there is not has a nearest one
    text = read_source(find_file(like, "experiments", search)).text
    if rig is not None:
        of = f"rig: {plain_text(rig)}"
        text, count = _RIG.subn(lambda line: f"{of}{line[1]}", text)
        text = text if count else f"{of}\n{text}"  # whoever extends another need not say it
    return (
        f"# Begun as {like}. What a word means, `rig explain WORD` says; what is wrong, all at\n"
        f"# once, `rig check {name}.yaml`.\n"
        f"name: {plain_text(name)}\n"
        f"description: What it is for, in one sentence\n{_OWN.sub('', text)}"
    )


def _first_of(rig: str, search: Sequence[Path]) -> str:
    """Return the first experiment of a rig, or else of the nearest one that it extends.

    Raises
    ------
    ConfigurationError
        There is none, or no such rig.
    """
    files = load_document(find_file(rig, "rigs", search), "rigs", search, Problems()).files
    named = {name: rig_of(name, search) for name in list_files("experiments", search)}
    found = {name: _file_of(own, search) for name, own in named.items() if own is not None}
    for file in files:
        for name, its in found.items():
            if its == file.resolve():
                return name
    base = ", nor of what it extends" if len(files) > 1 else ""
    raise ConfigurationError(f"no experiment is of the rig {rig!r}{base}; name one with --like")


def _file_of(rig: str, search: Sequence[Path]) -> Path | None:
    try:
        return find_file(rig, "rigs", search).resolve()
    except ConfigurationError:
        return None


def profile_text(name: str, like: str, search: Sequence[Path]) -> str:
    """Return a profile that is another one's in all, whose lines follow as comments.

    Raises
    ------
    ConfigurationError
        There is no such profile.
    """
    return (
        f"extends: {plain_text(like)}\n"
        f"name: {plain_text(name)}\n"
        "description: What it is, in one sentence\n\n" + commented_lines(name, like, search)
    )


def _with_cylinders(text: str, profile: Profile) -> str:
    """Return a profile's lines with the plant's cylinders, which have to be the mechanism's.

    Whoever writes another stroke has to write it twice; where a profile says the plant's default,
    nothing would show where.
    """
    if profile.plant is None:
        return text
    inner: list[str] = []
    own: list[str] = []
    for key, place, value in shared_lengths(profile):
        if f"plant.{place}" not in profile.places:
            said = f"{key}: {value * 1e3:g} mm"
            (inner if place.startswith("cylinder.") else own).append(said)
    lines = [f"  cylinder: {{{', '.join(inner)}}}   # as the mechanism's"] if inner else []
    lines += [f"  {one}   # as the mechanism's" for one in own]
    return _PLANT.sub(lambda found: "\n".join([found[0], *lines]), text)


def commented_lines(name: str, like: str, search: Sequence[Path]) -> str:
    """Return the lines of a profile as comments, below a few on what to do with them."""
    text = _OWN.sub("", read_source(find_file(like, "rigs", search)).text)
    text = _with_cylinders(text, load_profile(like, REGISTRY, (), search))
    lines = [f"# {line}".rstrip() for line in text.splitlines()]
    return (
        f"# The values of {like} hold where the lines above say nothing: they follow below.\n"
        "# Take the # away from what differs, and from the lines above that it belongs to. What a\n"
        "# key means, `rig explain KEY` says; what holds, and who says so,\n"
        f"# `rig check {name}.yaml --values`. `plant:` is the simulated rig: say there, too, what\n"
        "# is true of yours.\n\n" + "\n".join(lines) + "\n"
    )
