"""Drawn mistakes of files: in their bytes, in their lines, in what they say, and in their place."""

import copy
import json
import os

import yaml

from rig.config.calibration import seal

ESCAPE = "\x1b]0;pwned\x07"
PAGE = "<script>alert(1)</script>"
BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{chr(98 + k)}: &{chr(98 + k)} [{', '.join([f'*{chr(97 + k)}'] * 10)}]\n" for k in range(10)
)
WRONG = (
    None, True, False, "", "x", ESCAPE, PAGE, "=cmd|' /C calc'!A0", [], {}, [1.0, None], {"a": {}},
    0, -1, 1e-12, 1e300, -1e300, float("inf"), float("nan"), 10**30, "9" * 400, "x" * 200_000,
    "../../../etc/passwd", "/dev/zero", "\ud800", "\x00", "35 kPa", "5 furlong", "1e999 m",
    "2026-11", [[[[[[]]]]]], ["x"] * 1000, "!!python/object/apply:os.system [touch PWNED]", "~",
    "-0.0", "1e400", "9999-99-99", "*", "%s%n{0.__class__}", "a: b", "[", "- x",
)  # fmt: skip
PLACES = ("pipe", "endless", "loose", "folder", "loop", "secret")
"""What may stand in the place of a file."""


def spoil_bytes(content, chance):
    """Return bytes of which some were lost, doubled, flipped or come from elsewhere."""
    content = bytearray(content)
    for _ in range(chance.choice([1, 1, 2, 5])):
        at = chance.randrange(len(content) + 1)
        kind = chance.randrange(6)
        if kind == 0 and content:
            content[min(at, len(content) - 1)] ^= 1 << chance.randrange(8)
        elif kind == 1:
            del content[at:]
        elif kind == 2:
            content[at:at] = chance.randbytes(chance.randrange(1, 40))
        elif kind == 3:
            piece = content[at : at + chance.randrange(200)]
            content[at:at] = piece * chance.choice([1, 2, 50])
        elif kind == 4:
            content[at : at + chance.randrange(1, 60)] = b""
        else:
            content[at:at] = chance.choice(
                [b"\x00", b"\xff\xfe", ESCAPE.encode(), b"[" * 100_000, b"\r", b"\xef\xbb\xbf",
                 b"\n" * 3000, b"x" * 3_000_000, b"\xed\xa0\x80", b'"', b","]
            )  # fmt: skip
    return bytes(content)


def spoil_lines(text, chance):
    """Return lines of which some were lost, doubled, moved or have another value."""
    lines = text.split("\n")
    for _ in range(chance.choice([1, 1, 2, 4])):
        at = chance.randrange(len(lines))
        kind = chance.randrange(6)
        if kind == 0:
            lines.pop(at)
        elif kind == 1:
            lines.insert(chance.randrange(len(lines)), lines[at])
        elif kind == 2:
            lines[at] = lines[at] * chance.choice([2, 1000])
        elif kind == 3:
            key, colon, _ = lines[at].partition(":")
            lines[at] = f"{key}{colon or ':'} {_told(chance.choice(WRONG))}"
        elif kind == 4:
            cells = lines[at].split(",")
            cells[chance.randrange(len(cells))] = _told(chance.choice(WRONG))
            lines[at] = ",".join(cells)
        else:
            lines[at] = chance.choice([BOMB, "[" * 3000, "{a: " * 3000, "<<: *x", "? x", "\t"])
        lines = lines or [""]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


def spoil_data(data, chance):
    """Return plain data of which a value, a key or a list is another."""
    data = copy.deepcopy(data)
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        places = list(_places(data))
        if not places:
            return chance.choice(WRONG)
        held, key = chance.choice(places)
        kind = chance.randrange(6)
        if kind == 0:
            del held[key]
        elif kind == 1 and isinstance(held, dict):
            held[str(chance.choice(["x", ESCAPE, PAGE, "", "../x", "seal", "a" * 9000]))] = held[
                key
            ]
        elif kind == 2 and isinstance(held[key], (int, float)) and not isinstance(held[key], bool):
            held[key] = chance.choice([0, -held[key], 1e-12, 1e6 * held[key], 1e300, float("inf")])
        elif kind == 3 and isinstance(held, list):
            held.extend(held[:] * chance.choice([1, 100]))
        elif kind == 4:
            held[key] = [held[key]] if chance.random() < 0.5 else {"value": held[key]}
        else:
            held[key] = copy.deepcopy(chance.choice(WRONG))
    return data


def as_yaml(data):
    """Return plain data as YAML that holds whatever they hold."""
    try:
        return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=100).encode()
    except (yaml.YAMLError, UnicodeError):
        return repr(data).encode("utf-8", "backslashreplace")


def as_sealed_yaml(data):
    """Return plain data as the file of a program that was taken in, or of somebody with skill."""
    return seal(as_yaml(data).decode()).encode()


def as_json(data):
    """Return plain data as JSON, with the numbers that JSON does not have."""
    return json.dumps(data).encode()


def as_json_lines(data):
    """Return a list as a line of JSON each."""
    items = data if isinstance(data, list) else [data]
    return b"".join(json.dumps(item).encode() + b"\n" for item in items)


def replace(path, what, secret):
    """Put something else in the place of a file."""
    path.unlink(missing_ok=True)
    if what == "pipe":
        os.mkfifo(path)
    elif what == "folder":
        path.mkdir()
    else:
        to = {"endless": "/dev/zero", "loose": "/nowhere/x", "loop": path.name, "secret": secret}
        path.symlink_to(to[what])


def _told(value):
    return value if isinstance(value, str) else json.dumps(value)


def _places(data):
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in list(items):
        yield data, key
        if isinstance(value, dict | list):
            yield from _places(value)
