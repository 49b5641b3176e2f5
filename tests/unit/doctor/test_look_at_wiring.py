"""What is said of the interfaces, ports and cameras that a profile names."""

import os

import pytest

import drivers.can.socketcan
from rig.assembly import REGISTRY
from rig.config import load_profile
from rig.config.names import find_configs
from rig.doctor.look import Fitness
from rig.doctor.wiring import look_at_wiring
from rig.hal import ConnectionFailed


def look(rig, *changes):
    profile = load_profile(rig, REGISTRY, changes, find_configs(None))
    return list(look_at_wiring(profile))


def test_a_bus_that_is_not_up_has_the_command_that_sets_it_up(monkeypatch):
    def refuse(channel, bitrate):
        raise ConnectionFailed(channel, f"the interface is down; set it up with: ip {bitrate}")

    monkeypatch.setattr(drivers.can.socketcan, "open_socketcan", refuse)
    (found,) = look("cylinder")
    assert found == (
        "bus can0, socketcan can0", "the interface is down", Fitness.NO,
        "set it up with: ip 1000000",
    )  # fmt: skip


def test_a_bus_that_is_up_is_let_go_of(monkeypatch):
    opened = []

    class Bus:
        def shutdown(self):
            opened.append("let go")

    monkeypatch.setattr(
        drivers.can.socketcan, "open_socketcan", lambda *at: opened.append(at) or Bus()
    )
    (found,) = look("cylinder")
    assert (found.verdict, opened) == (Fitness.OK, [("can0", 1_000_000), "let go"])


def port(path):
    (found,) = look("legs", f"buses.chain.port={path}")
    return found


def test_a_port_that_is_not_there_has_others_that_are(tmp_path):
    folder = tmp_path / "dev"
    folder.mkdir()
    assert port("/dev/rig-none9").mend == "plug it in"
    found = port("/dev/null9")
    assert (found.verdict, found.found) == (Fitness.NO, "is not there")
    assert "/dev/null" in found.mend


def test_a_port_that_may_not_be_opened_comes_with_what_opens_it(monkeypatch):
    assert port("/dev/null").verdict is Fitness.OK
    monkeypatch.setattr(os, "access", lambda *_: False)
    found = port("/dev/null")
    assert (found.verdict, found.found) == (Fitness.NO, "may not be opened")
    assert found.mend == "sudo chmod a+rw /dev/null"


def test_a_folder_is_no_port():
    assert port("/dev/shm").found == "is no device"


@pytest.mark.parametrize(
    ("source", "path"),
    [
        ("{kind: uvc, path: /dev/video7}", "/dev/video7"),
        ("{kind: uvc, path: '7'}", "/dev/video7"),
        ("{kind: video, path: some.mp4}", None),
    ],
)
def test_a_camera_of_the_system_is_looked_for(source, path):
    found = [one.what for one in look("joint", f"devices.camera.source={source}")]
    cameras = [what for what in found if what.startswith("device")]
    assert cameras == ([] if path is None else [f"device camera, {path}"])
