"""`rig new rig --scan PORT`: servos of a chain that nobody wrote down, over a pseudo-terminal."""

import threading

import pytest
import yaml
from dynamixel_terminal import PseudoTerminal

from rig.assembly import REGISTRY, Backend, build_rig
from rig.cli import invoke
from rig.config import find_configs, load_profile


@pytest.fixture
def chain():
    """Return the port of the legs' servos, whose numbers are not those of the profile."""
    legs = load_profile("legs", REGISTRY, (), find_configs(None))
    numbers = {name: its.id + 40 for name, its in legs.devices["servos"].settings.joints.items()}
    said = [f"devices.servos.joints.{name}.id={number}" for name, number in numbers.items()]
    profile = load_profile("legs", REGISTRY, said, find_configs(None))
    rig = build_rig(profile, Backend.VIRTUAL)
    (line,) = rig.clock.world.buses
    terminal, over = PseudoTerminal(line.chain), threading.Event()
    thread = threading.Thread(target=terminal.serve, args=(over.is_set,), daemon=True)
    thread.start()
    yield terminal.path
    over.set()
    thread.join()
    terminal.close()


def test_a_chain_is_scanned_and_its_servos_are_found_by_their_numbers(chain, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["new", "rig", "mine", "--like", "legs", "--scan", chain]
    assert invoke(words) == 0
    written = yaml.safe_load((tmp_path / "mine.yaml").read_text())
    assert written["buses"] == {"chain": {"port": chain}}
    joints = written["devices"]["servos"]["joints"]
    assert [its["id"] for its in joints.values()] == [40 + k for k in range(1, 13)]
    assert invoke(["check", "mine.yaml"]) == 0


def test_more_ports_than_lines_are_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["new", "rig", "mine", "--like", "legs", "--scan", "/dev/a,/dev/b"]
    assert invoke(words) == 2
    assert "2 serial ports" in capsys.readouterr().err
