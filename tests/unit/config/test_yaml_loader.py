"""Strict YAML: what is read, what is refused, and where it says so."""

import os

import pytest

from rig.config.diagnostics import Problems, ProfileError
from rig.config.located import Source
from rig.config.yaml_loader import MAX_BYTES, MAX_DEPTH, parse, read_source
from rig.hal import ConfigurationError


def load(text, **options):
    problems = Problems()
    root = parse(Source("file.yaml", text), problems, **options)
    problems.raise_if_any()
    return root


def locations(node, path=()):
    """Yield the path and the mark of a value and of all below it."""
    yield path, node.mark
    below = node.value if isinstance(node.value, dict | list) else ()
    for key, item in below.items() if isinstance(below, dict) else enumerate(below):
        yield from locations(item, (*path, key))


def errors_of(text):
    with pytest.raises(ProfileError) as caught:
        load(text)
    return [(d.mark.line, d.mark.column, d.message) for d in caught.value.diagnostics]


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3), ("1E5", 1e5), ("-.5", -0.5), ("5.", 5.0), ("+3", 3), ("0", 0), ("0x1F", 31),
        ("true", True), ("false", False), ("null", None), ("~", None), ("", None),
        ("yes", "yes"), ("no", "no"), ("on", "on"), ("off", "off"), ("True", "True"), ("NULL",
         "NULL"),
        ("2026-11-21", "2026-11-21"), ("12:30", "12:30"), ("1_000", "1_000"), ("0o17", "0o17"),
        ("0b11", "0b11"), ("'1'", "1"), ('"true"', "true"), ("35 kPa",
         "35 kPa"), ("1" * 30, float("1" * 30)),
    ],
)  # fmt: skip
def test_scalars(text, value):
    read = load(f"key: {text}\n").plain()["key"]
    assert read == value
    assert type(read) is type(value)


def test_every_value_knows_its_place():
    root = load("a:\n  b: [1, {c: 2}]\n  d: 'x'\n")
    marks = {path: (mark.line, mark.column) for path, mark in locations(root)}
    assert marks == {
        (): (1, 1), ("a",): (2, 3), ("a", "b"): (2, 6), ("a", "b", 0): (2, 7),
        ("a", "b", 1): (2, 10), ("a", "b", 1, "c"): (2, 14), ("a", "d"): (3, 6),
    }  # fmt: skip


def test_keys_are_text_as_written():
    assert load("on: 1\n1: 2\n0x10: 3\n1.0: 4\nnull: 5").plain() == {
        "on": 1, "1": 2, "0x10": 3, "1.0": 4, "null": 5
    }  # fmt: skip


@pytest.mark.parametrize(
    ("text", "line", "column", "message"),
    [
        ("a: 1\na: 2", 2, 1, "a is here twice; first in line 1"),
        ("a: 1\n'a': 2", 2, 1, "twice"),
        ("a: &x 1", 1, 4, "anchor &x"),
        ("b: *x", 1, 4, "alias *x"),
        ("<<: {a: 1}", 1, 1, "merge keys"),
        ("a: !!int '3'", 1, 4, "tags"),
        ("a: !python/name:os.system x", 1, 4, "tags"),
        ("&k a: 1", 1, 1, "anchors and tags"),
        ("a: 010", 1, 4, "leading zero"),
        ("a: 1\n\tb: 2", 2, 1, "a tab"),
        ("a: \x00", 1, 4, "U+0000"),
        ('a: "x\\0y"', 1, 4, "control character"),
        ("? [a]\n: 1", 1, 3, "a key must be plain text"),
        ("a: 1\n---\nb: 2", 2, 1, "second document"),
        ("%YAML 1.1\n---\na: 1", 1, 1, "directives"),
        ("", 1, 1, "the file is empty"),
        ("# nothing\n", 1, 1, "the file is empty"),
        ("a: [1, 2", 1, 9, "flow sequence"),
        ("a: b: c", 1, 5, "mapping values"),
        ("'': 1", 1, 1, "a key must be text"),
        ("x" * 5 + ": " + "[" * 100, 1, 7 + MAX_DEPTH, "levels deep"),
    ],
)
def test_refused_where_it_stands(text, line, column, message):
    found = errors_of(text)
    assert found[0][:2] == (line, column)
    assert message in found[0][2]


def test_all_refusals_at_once():
    found = errors_of("a: &x 1\nb: *x\nb: !t 3\nc: 007\n<<: {d: 1}\n")
    assert [line for line, _, _ in found] == [1, 2, 3, 3, 4, 5]


def test_deep_nesting_neither_recurses_nor_hangs():
    told = errors_of("[" * 200_000)[-1][2]
    assert "levels deep" in told or "maximum nesting depth" in told  # libyaml's own, where newer
    assert errors_of("- " * 100_000)
    assert "levels deep" in errors_of("{a: " * 50_000)[-1][2]


def test_the_python_parser_finds_the_same(monkeypatch):
    import importlib

    import yaml

    from rig.config import yaml_loader

    text = "a: [1, {b: 35 kPa}]\nc: 'x'\n"
    fast = list(locations(load(text)))
    monkeypatch.delattr(yaml, "CSafeLoader")
    try:
        slow = importlib.reload(yaml_loader)
        root = slow.parse(Source("file.yaml", text), Problems())
        assert [(path, mark[1:]) for path, mark in locations(root)] == [
            (path, mark[1:]) for path, mark in fast
        ]
        with pytest.raises(ProfileError, match="levels deep"):
            slow.parse(Source("file.yaml", "[" * 1000), Problems())
    finally:
        monkeypatch.undo()
        importlib.reload(yaml_loader)


def test_one_line_values_are_in_flow_style():
    assert load("  {a: [1]}", flow_only=True).plain() == {"a": [1]}
    with pytest.raises(ProfileError, match="write a mapping as"):
        load("a: 1", flow_only=True)


class TestReadSource:
    def test_byte_order_mark_and_line_ends(self, tmp_path):
        path = tmp_path / "a.yaml"
        path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: 2\r\n")
        root = parse(read_source(path), Problems())
        assert root.plain() == {"a": 1, "b": 2}

    def test_not_utf8(self, tmp_path):
        path = tmp_path / "a.yaml"
        path.write_bytes(b"a: 1\nb: \xff\xfe\n")
        with pytest.raises(ProfileError, match=r"a\.yaml:2:4: byte 0xFF is not UTF-8"):
            read_source(path)

    @pytest.mark.parametrize("content", [b"\x00" * 10, "a: 1".encode("utf-16")])
    def test_binary(self, tmp_path, content):
        path = tmp_path / "a.yaml"
        path.write_bytes(content)
        with pytest.raises(ProfileError):
            parse(read_source(path), Problems())

    def test_missing_directory_pipe_and_huge(self, tmp_path):
        with pytest.raises(ConfigurationError, match="No such file"):
            read_source(tmp_path / "none.yaml")
        with pytest.raises(ConfigurationError, match="it is a directory"):
            read_source(tmp_path)
        os.mkfifo(tmp_path / "pipe")
        with pytest.raises(ConfigurationError, match="not a regular file"):
            read_source(tmp_path / "pipe")
        (tmp_path / "huge").write_bytes(b"#" * (MAX_BYTES + 1))
        with pytest.raises(ConfigurationError, match="more than 1048576 bytes"):
            read_source(tmp_path / "huge")
        with pytest.raises(ConfigurationError, match="null"):
            read_source(tmp_path / "nul\0")

    def test_no_permission(self, tmp_path, monkeypatch):
        path = tmp_path / "a.yaml"
        path.write_text("a: 1")
        path.chmod(0)
        if os.access(path, os.R_OK):  # the superuser may read anything: let the system refuse

            def refuse(*_):
                raise PermissionError(13, "Permission denied")

            monkeypatch.setattr(os, "open", refuse)
        with pytest.raises(ConfigurationError, match="Permission denied"):
            read_source(path)
