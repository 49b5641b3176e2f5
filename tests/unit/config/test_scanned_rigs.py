"""Who is who among devices that answer on a bus: drawn numbers, kinds, strangers and absentees."""

import random
from collections import Counter

import pytest
import yaml

from rig.assembly import REGISTRY
from rig.config import find_configs, load_profile
from rig.hal import Address
from rig.hal.frames import Found
from rig.scaffolding.scanned import _camera_lines, _stranger_lines, match
from rig.scaffolding.seen_cameras import SeenCamera, seen_cameras

KINDS = (401, 406, 402, None)


def drawn(seed):
    """Return addresses of a profile, and what answers on a bus on which some have moved."""
    chance = random.Random(seed)
    numbers = chance.sample(range(1, 128), 40)
    expected = [
        Address(f"device-{k}", numbers.pop(), chance.choice(KINDS[:3]))
        for k in range(chance.randint(1, 9))
    ]
    found = []
    for its in expected:
        fate = chance.random()
        if fate < 0.4:
            found.append(Found(its.number, profile=its.profile))
        elif fate < 0.8:
            found.append(Found(numbers.pop(), profile=its.profile))
    found += [
        Found(numbers.pop(), profile=chance.choice(KINDS), answers=chance.randint(0, 1))
        for _ in range(chance.randint(0, 3))
    ]
    chance.shuffle(found)
    return expected, found


@pytest.mark.parametrize("seed", range(200))
def test_every_device_that_can_be_one_is_one_and_nothing_is_lost(seed):
    expected, found = drawn(seed)
    devices, missing, others = match(expected, found)
    kinds = {its.name: its.profile for its in expected}
    assert all(found.profile == kinds[name] for name, found in devices.items())
    # Whatever answers is one device, or another's; whatever is expected is found, or missing.
    assert Counter([*devices.values(), *others]) == Counter(found)
    assert Counter([*devices, *(its.name for its in missing)]) == Counter(list(kinds))
    for kind in KINDS[:3]:
        wanted = sum(its.profile == kind for its in expected)
        there = sum(item.profile == kind and item.answers > 0 for item in found)
        assert sum(kinds[name] == kind for name in devices) == min(wanted, there)
    # A number that fits is kept; the others come in the order of their numbers.
    here = {item.node: item for item in found if item.answers}
    moved = []
    for its in expected:
        if its.number in here and here[its.number].profile == its.profile:
            assert devices[its.name].node == its.number
        elif its.name in devices:
            moved.append((its.profile, devices[its.name].node))
    for kind in KINDS[:3]:
        nodes = [node for of, node in moved if of == kind]
        assert nodes == sorted(nodes)


def test_a_device_of_no_kind_is_whatever_answers():
    axis = Address("drives.q1", 3)
    assert match([axis], [Found(7, kind="ODrive")]).devices["drives.q1"].node == 7


def test_a_stranger_becomes_a_device_in_comments():
    item = Found(0x26, "CiA 410 (0x0002019A)", 410, vendor=0x12, product=0x34, serials=(7,))
    lines = _stranger_lines("can0", [item, Found(0x27)], [])
    assert all(line.startswith("  # ") for line in lines)
    read = yaml.safe_load("\n".join(line.removeprefix("  # ") for line in lines[1:8]))
    assert read == {
        "device-26": {
            "driver": "cia410", "bus": "can0", "node": 0x26, "vendor": 0x12, "product": 0x34,
            "serial": 7,
        }
    }  # fmt: skip
    assert any("rig new driver" in line for line in lines[8:])


def test_cameras_are_found_by_names_that_stay(tmp_path):
    for node, name, index in (("video10", "Late", 0), ("video0", "Stereo", 0), ("video1", "", 1)):
        folder = tmp_path / "sys/class/video4linux" / node
        folder.mkdir(parents=True)
        (folder / "name").write_text(f"{name}\n")
        (folder / "index").write_text(f"{index}\n")
    named = tmp_path / "dev/v4l/by-id"
    named.mkdir(parents=True)
    (tmp_path / "dev/video10").touch()
    (named / "usb-Late-index0").symlink_to("../../video10")
    assert seen_cameras(tmp_path) == [
        SeenCamera("/dev/video0", "Stereo"),
        SeenCamera("/dev/v4l/by-id/usb-Late-index0", "Late"),
    ]
    joint = load_profile("joint", REGISTRY, (), find_configs(None))
    lines = _camera_lines(joint, seen_cameras(tmp_path))
    assert yaml.safe_load("\n".join(lines)) == {
        "camera": {"source": {"kind": "uvc", "path": "/dev/video0"}}
    }
    assert "Late" in lines[-1]
    assert lines[-1].startswith("  # ")
