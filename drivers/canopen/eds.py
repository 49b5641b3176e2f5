"""Electronic data sheets: which objects a CANopen device has, as its maker wrote them down.

Only what is asked for is interpreted, so that a mistake in a part that nobody needs does not
make a device unusable; and every error names file and line, which `canopen` does not.

References
----------
CiA 306-1 V1.3, sections 4.5 (device) and 4.6 (object dictionary).
"""

import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Final, NamedTuple

from rig.hal import ConfigurationError
from rig.hal.files import read_regular

_SECTION: Final = re.compile(r"\[\s*([^\]]*?)\s*\]\s*(?:[;#].*)?")
_OBJECT: Final = re.compile(r"([0-9a-f]{4})(?:sub([0-9a-f]{1,2}))?")
_NODE_ID: Final = re.compile(r"\$nodeid", re.IGNORECASE)
_TYPES: Final = {
    0x01: "bool",
    0x02: "i8",
    0x03: "i16",
    0x04: "i32",
    0x05: "u8",
    0x06: "u16",
    0x07: "u32",
    0x08: "f32",
    0x09: "text",
    0x0A: "bytes",
    0x10: "i24",
    0x11: "f64",
    0x15: "i64",
    0x16: "u24",
    0x1B: "u64",
}
_ACCESS: Final = ("ro", "wo", "rw", "rwr", "rww", "const")
_NUMBER_OF_ENTRIES: Final = "number of entries"
_U8: Final = 0x05
_MOST_ELEMENTS: Final = 254
"""Of an array: sub-index 0 holds their number, 255 its structure (CiA 301, 7.4.3)."""
_MOST: Final = 8 << 20  # bytes; the largest sheets of makers have some hundred thousand


class EdsError(ConfigurationError):
    """An electronic data sheet cannot be understood.

    Parameters
    ----------
    path : Path
        The file.
    line : int
        From 1 on; 0 for the file as a whole.
    what : str
        What is wrong.
    """

    def __init__(self, path: Path, line: int, what: str) -> None:
        self.path = path
        self.line = line
        super().__init__(f"{path}:{line}: {what}" if line else f"{path}: {what}")


class EdsObject(NamedTuple):
    """One variable of a device.

    Attributes
    ----------
    index, sub : int
        Its address.
    name : str
        What the maker calls it.
    type : str
        ``i16`` and the like, as in `drivers.canopen.mapping`; else the type's own word.
    access : str
        ``ro``, ``wo``, ``rw``, ``rwr``, ``rww`` or ``const``.
    mappable : bool
        Whether a PDO may carry it.
    default : str
        As it is written; empty if there is none.
    line : int
        Of its section in the file.
    """

    object: int
    sub: int
    name: str
    type: str
    access: str
    mappable: bool
    default: str
    line: int


class _Entry(NamedTuple):
    text: str
    line: int


class _Section:
    """The entries of one section by their names in lower case."""

    def __init__(self, line: int) -> None:
        self.line = line
        self.entries: dict[str, _Entry] = {}


class Eds:
    """The content of one file.

    Raises
    ------
    EdsError
        It is not of sections and entries, or has no object at all.
    """

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self._sections: dict[str, _Section] = {}
        self._read(text)
        if not any(_OBJECT.fullmatch(name) for name in self._sections):
            raise EdsError(path, 0, "this is no EDS file: it describes no object")

    def find(self, index: int, sub: int) -> EdsObject | None:
        """Return a variable; None if the device has none there.

        Raises
        ------
        EdsError
            It has one, but what is written of it makes no sense.
        """
        own = self._sections.get(f"{index:04x}")
        if own is None:
            return None
        part = self._sections.get(f"{index:04x}sub{sub:x}")
        if part is None and sub < 0x10:
            part = self._sections.get(f"{index:04x}sub{sub:02x}")
        if part is not None:
            return self._variable(index, sub, part)
        compact = self._compact_count(own)
        if compact:
            return self._compact(index, sub, own, compact)
        if sub == 0 and self._number(own, "ObjectType", 7) not in (8, 9):
            return self._variable(index, 0, own)
        return None

    def objects(self) -> Iterator[EdsObject]:
        """Yield every variable of the device, those of each object in their order.

        Raises
        ------
        EdsError
            What is written of one makes no sense.
        """
        seen: set[tuple[int, int]] = set()
        for name, section in self._sections.items():
            place = _OBJECT.fullmatch(name)
            if place is None:
                continue
            index = int(place[1], 16)
            if place[2] is not None:
                subs: Iterable[int] = (int(place[2], 16),)
            else:
                subs = range(self._compact_count(section) + 1)
            for sub in subs:
                found = None if (index, sub) in seen else self.find(index, sub)
                if found is not None:
                    seen.add((index, sub))
                    yield found

    def name_of(self, index: int, sub: int) -> str | None:
        """Return what the maker calls a variable: its object's name and its own."""
        try:
            found = self.find(index, sub)
        except EdsError:
            return None
        if found is None:
            return None
        own = self._sections[f"{index:04x}"].entries.get("parametername")
        if own is None or not own.text or own.text == found.name:
            return found.name
        return f"{own.text} / {found.name}" if found.name else own.text

    def type_of(self, index: int, sub: int) -> str | None:
        """Return the type of a variable if `drivers.canopen.mapping` has it."""
        from drivers.canopen.mapping import SIZES

        try:
            found = self.find(index, sub)
        except EdsError:
            return None
        return found.type if found is not None and found.type in SIZES else None

    def number_of(self, index: int, sub: int, node: int) -> int | None:
        """Return the default of a variable for a node number, if it has one that is a number."""
        try:
            found = self.find(index, sub)
            return None if found is None else self.default_of(found, node)
        except EdsError:
            return None

    def default_of(self, found: EdsObject, node: int) -> int | None:
        """Return the default of an integer variable, for a node number; None if there is none.

        Raises
        ------
        EdsError
            It is not a number.
        """
        if not found.default:
            return None
        what = f"DefaultValue of 0x{found.object:04X}:{found.sub:02X}"
        return self._parse(_Entry(found.default, found.line), what, node)

    def device_number(self, key: str, default: int) -> int:
        """Return a number of the section DeviceInfo, or a default where it is not given.

        Raises
        ------
        EdsError
            It is not a number.
        """
        section = self._sections.get("deviceinfo")
        return default if section is None else self._number(section, key, default)

    # Reading --------------------------------------------------------------------------

    def _read(self, text: str) -> None:
        section: _Section | None = None
        free = False  # of a section whose content is free text
        for number, raw in enumerate(text.splitlines(), 1):
            line = raw.strip("\ufeff \t\r\x1a")
            if not line or line[0] in ";#":
                continue
            if line[0] == "[":
                found = _SECTION.fullmatch(line)
                if found is None:
                    raise EdsError(self.path, number, "a section's name has no end")
                name = found[1].lower()
                if name in self._sections:
                    first = self._sections[name].line
                    raise EdsError(
                        self.path, number, f"section [{found[1]}] is in line {first} already"
                    )
                section = self._sections[name] = _Section(number)
                free = name == "comments"
                continue
            key, equals, value = line.partition("=")
            if section is None or not equals:
                if free:
                    continue
                # What stands there is not quoted: the file may be any that a profile names.
                raise EdsError(self.path, number, "expected [section] or name=value")
            section.entries.setdefault(key.strip().lower(), _Entry(_bare(value), number))

    def _variable(self, index: int, sub: int, section: _Section) -> EdsObject:
        entries = section.entries
        thing = f"0x{index:04X}:{sub:02X}"
        if not entries.get("datatype", _Entry("", 0)).text:
            raise EdsError(self.path, section.line, f"object {thing} has no DataType")
        kind = self._number(section, "DataType", 0)
        access = entries.get("accesstype", _Entry("", section.line))
        if access.text.lower() not in _ACCESS:
            raise EdsError(
                self.path,
                access.line,
                f"AccessType of {thing} is {access.text!r}, expected one of {', '.join(_ACCESS)}",
            )
        name = entries.get("parametername", _Entry("", 0)).text
        return EdsObject(
            index,
            sub,
            name,
            _TYPES.get(kind, f"type 0x{kind:04X}"),
            access.text.lower(),
            bool(self._number(section, "PDOMapping", 0)),
            entries.get("defaultvalue", _Entry("", 0)).text,
            section.line,
        )

    def _compact(self, index: int, sub: int, own: _Section, count: int) -> EdsObject | None:
        """Return an element of an array that is written as one section (CompactSubObj)."""
        if sub > count:
            return None
        if sub == 0:
            return EdsObject(
                index, 0, _NUMBER_OF_ENTRIES, _TYPES[_U8], "ro", False, str(count), own.line
            )
        made = self._variable(index, sub, own)
        values = self._sections.get(f"{index:04x}value")
        names = self._sections.get(f"{index:04x}name")
        default = values.entries.get(str(sub)) if values else None
        called = names.entries.get(str(sub)) if names else None
        return made._replace(
            name=called.text if called else f"{made.name}{sub}",
            default=default.text if default else made.default,
        )

    def _compact_count(self, section: _Section) -> int:
        """Return how many elements an array in one section has; 0 of all other objects."""
        count = self._number(section, "CompactSubObj", 0)
        if not 0 <= count <= _MOST_ELEMENTS:
            line = section.entries["compactsubobj"].line
            what = f"CompactSubObj is {count}, expected 0 to {_MOST_ELEMENTS}"
            raise EdsError(self.path, line, what)
        return count

    def _number(self, section: _Section, key: str, default: int) -> int:
        entry = section.entries.get(key.lower())
        return default if entry is None or not entry.text else self._parse(entry, key, 0)

    def _parse(self, entry: _Entry, what: str, node: int) -> int:
        """Return a number: decimal, hexadecimal, octal, or a sum with ``$NODEID``."""
        try:
            return sum(map(_number, _NODE_ID.sub(str(node), entry.text).split("+")))
        except ValueError:
            raise EdsError(
                self.path, entry.line, f"{what} is {entry.text!r}, expected a number"
            ) from None


def read_eds(path: Path) -> Eds:
    """Read an EDS or DCF file.

    Raises
    ------
    ConfigurationError
        It cannot be read.
    EdsError
        It cannot be understood; with the line.
    """
    return Eds(path, decode_text(read_regular(path, _MOST)))


def decode_text(content: bytes) -> str:
    """Return the text of a file: UTF-8, or Latin-1 as most tools for EDS files write."""
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _bare(value: str) -> str:
    """Return a value without the comment behind it."""
    return re.split(r"\s;|^;", value, maxsplit=1)[0].strip()


def _number(text: str) -> int:
    text = text.strip().lower()
    sign = -1 if text.startswith("-") else 1
    digits = text.lstrip("+-")
    if digits.startswith("0x"):
        return sign * int(digits, 16)
    if len(digits) > 1 and digits[0] == "0" and not set(digits) - set("01234567"):
        return sign * int(digits, 8)  # as the standard says
    return sign * int(digits, 10)
