"""A profile's interfaces are what they are called: no URL, no file, no machine elsewhere."""

import os
import pty

import pytest

from drivers.can import open_bus
from drivers.canopen.settings import CanBusSettings
from drivers.dynamixel.port import open_port
from drivers.dynamixel.settings import SerialBusSettings
from rig.cli import invoke
from rig.hal import ConnectionFailed

URLS = ("spy:///dev/null?file=VICTIM", "alt:///dev/null?class=VICTIM", "socket://127.0.0.1:9",
        "rfc2217://127.0.0.1:9", "loop://", "hwgrep://.*", "cp2110:0001:004a:00", "VICTIM",
        "/dev/../VICTIM", "relative/path", "/dev/null?file=VICTIM")  # fmt: skip
SERIAL = ("slcan", "robotell", "seeedstudio", "serial")


@pytest.fixture
def victim(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "settings"))
    path = tmp_path / "victim"
    path.write_text("precious\n")
    yield path
    assert path.read_text() == "precious\n"


@pytest.mark.parametrize("interface", SERIAL)
@pytest.mark.parametrize("url", URLS)
def test_a_url_opens_nothing(interface, url, victim, tmp_path, capsys):
    channel = url.replace("VICTIM", str(victim))
    with pytest.raises(ConnectionFailed):
        open_bus(CanBusSettings(interface, channel))
    profile = tmp_path / "mine.yaml"
    profile.write_text(
        f"extends: cylinder\nbuses:\n  can0:\n    interface: {interface}\n"
        f"    channel: '{channel}'\n"
    )
    code = invoke(["check", str(profile), "--on", "hardware"])
    err = capsys.readouterr().err
    if channel.startswith("/") and "?" not in channel and ".." not in channel:
        assert code == 3 and "is no serial line" in err  # a path, but of no serial line
    else:
        assert code == 2 and f"{profile}:5:14: the channel of {interface} is" in err


@pytest.mark.parametrize(
    ("interface", "channel", "options"),
    [("socketcan", "can0/../x", {}), ("socketcan", "a" * 16, {}), ("pcan", "http://x", {}),
     ("udp_multicast", "192.0.2.1", {}), ("udp_multicast", "evil.invalid", {}),
     ("socketcand", "can0", {"host": "192.0.2.1", "port": 29536}), ("plug-in", "can0", {}),
     ("neovi", "0", {"override_library_name": "/tmp/evil.so"}),
     ("usb2can", "0", {"dll": "C:\\evil.dll"}), ("kvaser", "../0", {})],
)  # fmt: skip
def test_other_things_than_a_device_or_a_name_are_refused(interface, channel, options, victim):
    settings = CanBusSettings(interface, channel, options=options)
    assert settings.trouble()
    with pytest.raises(ConnectionFailed, match="allowed by a line INTERFACE:CHANNEL in"):
        open_bus(settings)


def test_the_user_of_a_machine_may_allow_more(victim, tmp_path):
    settings = CanBusSettings("socketcand", "can0", options={"host": "192.0.2.1", "port": 29536})
    assert settings.trouble()
    (tmp_path / "settings" / "rig").mkdir(parents=True)
    (tmp_path / "settings" / "rig" / "interfaces").write_text("virtual:x\nsocketcand:can0\n")
    assert settings.trouble() is None
    assert CanBusSettings("socketcand", "can1").trouble()


@pytest.mark.parametrize(
    ("interface", "channel"),
    [("socketcan", "can0"), ("socketcan", "vcan12"), ("virtual", "test"), ("pcan", "PCAN_USBBUS1"),
     ("kvaser", "0"), ("slcan", "/dev/ttyACM0"), ("slcan", "/dev/ttyACM0@115200"),
     ("slcan", "/dev/serial/by-id/usb-CANable_1.0-if00"), ("udp_multicast", "239.74.163.2"),
     ("udp_multicast", "ff15:7079:7468:6f6e:6465:6d6f:6d63:6173"), ("slcan", "/dev/pts/3")],
)  # fmt: skip
def test_what_is_usual_needs_no_permission(interface, channel):
    assert CanBusSettings(interface, channel).trouble() is None


@pytest.mark.parametrize("path", ["/dev/null", "/dev/zero", "VICTIM", "link"])
def test_a_serial_chain_opens_serial_lines_only(path, victim, tmp_path):
    (tmp_path / "link").symlink_to(victim)
    path = {"VICTIM": str(victim), "link": str(tmp_path / "link")}.get(path, path)
    with pytest.raises(ConnectionFailed, match="is no serial line"):
        open_port(SerialBusSettings(path))


def test_a_link_to_a_serial_line_is_one(tmp_path):
    master, slave = pty.openpty()
    (tmp_path / "mine").symlink_to(os.ttyname(slave))
    open_port(SerialBusSettings(str(tmp_path / "mine"))).close()
    os.close(master)
    os.close(slave)
