"""The manifest names whose code took part: distribution, version and a digest of its files."""

import random
import sys
from importlib.metadata import PathDistribution
from types import ModuleType

import pytest

from rig import plug_ins


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package of somebody else's with a row for drivers, imported; return its folder."""
    info = tmp_path / "their_rig-2.7.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: their-rig\nVersion: 2.7\n")
    (info / "entry_points.txt").write_text("[rig.drivers]\ntheir-scale = their_rig.parts:PARTS\n")
    points = list(PathDistribution(info).entry_points)
    monkeypatch.setattr(
        plug_ins, "entry_points", lambda group: [p for p in points if p.group == group]
    )
    folder = tmp_path / "their_rig"
    (folder / "sub").mkdir(parents=True)
    (folder / "__init__.py").write_text("")
    (folder / "sub" / "table.bin").write_bytes(random.Random(3).randbytes(999))
    module = ModuleType("their_rig")
    module.__path__, module.__file__ = [str(folder)], str(folder / "__init__.py")
    monkeypatch.setitem(sys.modules, "their_rig", module)
    return folder


def test_a_package_that_takes_part_is_named(package):
    (told,) = plug_ins.plug_ins().items()
    assert told[0] == "their_rig"
    assert (told[1]["distribution"], told[1]["version"]) == ("their-rig", "2.7")
    assert len(told[1]["sha256"]) == 64


@pytest.mark.parametrize("seed", range(5))
def test_any_byte_of_any_file_is_in_the_digest(package, seed):
    before = plug_ins.plug_ins()["their_rig"]["sha256"]
    path = package / "sub" / "table.bin"
    content = bytearray(path.read_bytes())
    content[random.Random(seed).randrange(len(content))] ^= 1
    path.write_bytes(content)
    after = plug_ins.plug_ins()["their_rig"]["sha256"]
    assert after != before
    path.rename(package / "other.bin")
    assert plug_ins.plug_ins()["their_rig"]["sha256"] not in (before, after)


def test_compiled_files_are_not(package):
    before = plug_ins.plug_ins()
    (package / "__pycache__").mkdir()
    (package / "__pycache__" / "x.pyc").write_bytes(b"1")
    assert plug_ins.plug_ins() == before


def test_what_was_not_imported_is_not_named(package, monkeypatch):
    monkeypatch.delitem(sys.modules, "their_rig")
    assert plug_ins.plug_ins() == {}


def installed_in(folder, name, **files):
    info = folder / f"{name.replace('-', '_')}-1.5.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.5\n")
    for file, content in files.items():
        (info / {"top_level": "top_level.txt", "record": "RECORD"}[file]).write_text(content)
        if file == "record":  # readers of metadata may leave out what is not there
            for path in (folder / line.partition(",")[0] for line in content.split()):
                path.parent.mkdir(exist_ok=True)
                path.write_text("")


@pytest.mark.parametrize(
    "files",
    [
        {"top_level": "led_to\n"},
        {"record": "led_to/__init__.py,,\nled_to/more.py,,\n"},
        {"record": "led_to.py,,\n"},
    ],
    ids=["declared", "a package", "a module"],
)
def test_what_a_row_led_to_is_named_by_its_distribution(tmp_path, monkeypatch, files):
    installed_in(tmp_path / "site", "their-more", **files)
    installed_in(tmp_path / "site", "nobody-s", record="another/__init__.py,,\n")
    monkeypatch.syspath_prepend(tmp_path / "site")
    module = ModuleType("led_to")
    module.__file__ = str(tmp_path / "led_to.py")
    (tmp_path / "led_to.py").write_text("")
    monkeypatch.setitem(sys.modules, "led_to", module)
    plug_ins.note_import("led_to.parts")
    told = plug_ins.plug_ins()["led_to"]
    assert (told["distribution"], told["version"]) == ("their-more", "1.5")


def test_what_two_distributions_have_is_of_neither(tmp_path, monkeypatch):
    for name in ("one", "other"):
        installed_in(tmp_path / name, name, top_level="led_to")
        monkeypatch.syspath_prepend(tmp_path / name)
    monkeypatch.setitem(sys.modules, "led_to", ModuleType("led_to"))
    plug_ins.note_import("led_to")
    assert plug_ins._imported()["led_to"] == (None, None)


def test_what_is_installed_is_read_once(monkeypatch, tmp_path):
    read, times = plug_ins.metadata.entry_points, []

    def counted():
        times.append(1)
        return read()

    monkeypatch.setattr(plug_ins.metadata, "entry_points", counted)
    monkeypatch.syspath_prepend(tmp_path)  # another place to look in than any before
    for group in plug_ins.GROUPS:
        expected = read(group=group)
        assert list(plug_ins.entry_points(group=group)) == list(expected)
    assert len(times) == 1
