"""A device's own description file (``eds:``) beside what the profile says of the device."""

from dataclasses import replace
from pathlib import Path
from typing import Final

from rig.config.diagnostics import Problems
from rig.config.located import Node
from rig.config.named_files import beside
from rig.hal import ConfigurationError, DeviceFile, DriverSettings
from rig.hal.files import read_regular

KEY: Final = "eds"
"""The key of a device's entry that names the file."""

MOST: Final = 8 << 20
"""Bytes of the longest; the largest sheets of makers have some hundred thousand."""


class DeviceDescription:
    """The file that a device's entry names.

    What it means is the driver's affair (`rig.hal.DriverSettings.read_description`); this class
    knows where everything was written.

    Parameters
    ----------
    path : Path
        The file.
    node : Node
        Where the profile names it.
    content : DeviceFile
        What the driver read.
    problems : Problems
        Takes what does not fit.
    """

    def __init__(self, path: Path, node: Node, content: DeviceFile, problems: Problems) -> None:
        self.path = path
        self._node = node
        self._content = content
        self._problems = problems

    @classmethod
    def of(
        cls, settings: type[DriverSettings], entry: Node, problems: Problems
    ) -> "DeviceDescription | None":
        """Read the file of a device's entry; None if it names none, or a broken one."""
        node = entry.get(KEY)
        if node is None or not isinstance(node.value, str):
            return None
        path = beside(node) / node.value
        try:
            content = settings.read_description(path)
        except ConfigurationError as error:
            problems.add(node.mark, str(error))
            return None
        return None if content is None else cls(path, node, content, problems)

    def complete(self, entry: Node) -> Node:
        """Return the entry with what the file knows and the profile does not say."""
        try:
            plain = entry.plain()
            values = self._content.values(plain if isinstance(plain, dict) else {})
        except ConfigurationError as error:
            self._problems.add(self._node.mark, str(error))
            return entry
        for keys, value in values.items():
            entry = _with_default(entry, keys, Node(value, self._node.mark))
        return entry

    def compare(self, name: str, settings: DriverSettings, entry: Node) -> None:
        """Note everything that the device cannot do.

        Parameters
        ----------
        name : str
            The device's.
        settings : DriverSettings
            The driver's.
        entry : Node
            What they were built from.
        """
        try:
            findings = self._content.findings(name, settings)
        except ConfigurationError as error:
            self._problems.add(self._node.mark, str(error))
            return
        for keys, message in findings:
            place, taken = entry.descend(keys)
            if not taken:  # a default asks for it
                place = self._node
            scalar = not isinstance(place.value, dict | list)
            self._problems.add(place.mark if scalar else place.heading, f"{name}: {message}")


def _with_default(entry: Node, keys: tuple[str, ...], leaf: Node) -> Node:
    """Return a mapping with a value below some keys, unless there is one already."""
    if not isinstance(entry.value, dict):
        return entry  # null, or an error that is told elsewhere
    key, *rest = keys
    below = entry.value.get(key)
    if rest:
        below = below or Node({}, leaf.mark)
        made = _with_default(below, tuple(rest), leaf)
    elif below is None:
        made = leaf
    else:
        return entry
    return replace(entry, value={**entry.value, key: made})


def text_of(path: Path) -> str:
    """Return the text of a device's own file."""
    content = read_regular(path, MOST)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:  # most tools for EDS files write Latin-1
        return content.decode("latin-1")
