"""Read the parts of a profile or experiment that name code: drivers, controllers, plants."""

from typing import TypeVar, cast

from rig.config.diagnostics import Problems, nearest, shown
from rig.config.law_hint import hint_of_additions
from rig.config.located import BROKEN, Node
from rig.config.models import Settings
from rig.config.named_settings import Kind, Registry
from rig.config.names import is_name
from rig.config.settings import build
from rig.hal import BusSettings, ConfigurationError

T = TypeVar("T")


class Sections:
    """The top-level entries of one document.

    Parameters
    ----------
    root : Node
        The document's mapping.
    keys : tuple of str
        Every top-level key, for hints.
    registry : Registry
        The names of code.
    problems : Problems
        Takes every error.
    """

    def __init__(
        self, root: Node, keys: tuple[str, ...], registry: Registry, problems: Problems
    ) -> None:
        assert isinstance(root.value, dict)
        self.root = root
        self.keys = keys
        self.registry = registry
        self.problems = problems
        self._entries = dict(root.value)

    def take(self, key: str, *, required: bool = False) -> Node | None:
        """Take an entry out of the document; null is the same as none."""
        node = self._entries.pop(key, None)
        if node is not None and node.value is not None:
            return node
        if required:
            where = self.root.mark if node is None else node.heading
            self.problems.add(where, f"key {key!r} is missing")
        return None

    def rest(self, settings: type[T]) -> T | None:
        """Build a dataclass from all entries that were not taken."""
        return build(settings, self.root.with_items(self._entries), self.problems, also=self.keys)

    def named(self, key: str, *, names: bool = True) -> dict[str, Node]:
        """Take an entry that is a mapping of names to mappings."""
        node = self.take(key)
        found: dict[str, Node] = {}
        if node is not None and self.is_mapping(node, key):
            assert isinstance(node.value, dict)
            for name, entry in node.value.items():
                if names and not is_name(name):
                    self.problems.add(
                        entry.heading,
                        f"{shown(name)} cannot be a name in {key}",
                        "use letters, digits, and _ - + . after the first",
                    )
                elif self.is_mapping(entry, f"{key}.{name}"):
                    found[name] = entry
        return found

    def is_mapping(self, node: Node, what: str) -> bool:
        """Return whether a node is a mapping, and note it if not."""
        if isinstance(node.value, dict):
            return True
        if node.value is not BROKEN:
            self.problems.add(node.mark, f"{what} is {shown(node.plain())}, expected a mapping")
        return False

    def settings_of(self, kind: Kind, name: str, node: Node) -> type[Settings] | None:
        """Return the settings behind a name that the file gives at a node."""
        try:
            return self.registry.settings(kind, name)
        except KeyError:
            hint = nearest(name, self.registry.names(kind)) or ""
            if not hint.startswith("did you mean"):
                hint = f"is the package installed that it is of? {hint}".strip()
            message = f"no {kind} is called {shown(name)}"
            self.problems.add(node.mark, message, hint_of_additions(self.registry, hint))
            return None

    def admit_additions(self) -> None:
        """Let the additions of other packages take part that the file names."""
        node = self.root.get("additions")
        if node is None or not isinstance(node.value, list):  # which is said when it is built
            return
        for entry in node.value:
            if not isinstance(entry.value, str):
                continue
            try:
                self.registry.admit(entry.value)
            except KeyError:
                installed = ", ".join(self.registry.unnamed())
                hint = f"there are {installed}" if installed else "no installed package offers any"
                message = f"no additions are called {shown(entry.value)}"
                self.problems.add(entry.mark, message, hint)
            except ConfigurationError as error:
                self.problems.add(entry.mark, str(error))

    def chosen(
        self, kind: Kind, node: Node, key: str, default: str | None = None
    ) -> tuple[str, object] | None:
        """Build an entry whose `key` names the code that the keys beside it belong to.

        Returns
        -------
        name : str
            The name; `default` if the entry does not say.
        settings : object
            Its settings.
        """
        if not self.is_mapping(node, kind):
            return None
        assert isinstance(node.value, dict)
        items = dict(node.value)
        named = items.pop(key, node)
        name = default if default is not None and named is node else self.text(node, key)
        settings = None if name is None else self.settings_of(kind, name, named)
        if name is None or settings is None:
            return None
        built = build(settings, node.with_items(items), self.problems, also=(key,))
        return None if built is None else (name, built)

    def bus(self, node: Node, protocol: str) -> tuple[str, BusSettings] | None:
        """Build a bus's entry, which must name nothing that is not to be opened.

        Parameters
        ----------
        node : Node
            The entry.
        protocol : str
            What is spoken if the entry does not say.
        """
        chosen = self.chosen("bus", node, "protocol", protocol)
        if chosen is None:
            return None
        settings = cast("BusSettings", chosen[1])
        trouble = settings.trouble()
        if trouble is not None:
            named = next(filter(None, map(node.get, ("channel", "port"))), node)
            self.problems.add(named.mark, trouble)
        return chosen[0], settings

    def text(self, node: Node, key: str) -> str | None:
        """Return the text below a key of a mapping, None after noting why there is none."""
        assert isinstance(node.value, dict)
        entry = node.value.get(key)
        if entry is None:
            self.problems.add(node.heading, f"key {key!r} is missing")
        elif isinstance(entry.value, str):
            return entry.value
        elif entry.value is not BROKEN:
            self.problems.add(entry.mark, f"{key} is {shown(entry.plain())}, expected a name")
        return None
