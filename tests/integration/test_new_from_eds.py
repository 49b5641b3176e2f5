"""`rig new rig --scan --eds`: what a device's own file maps is what the profile has."""

import random

import canopen
import pytest

from rig.assembly import REGISTRY, check_profile
from rig.assembly.survey import Answer
from rig.cli import invoke
from rig.config import find_configs, load_profile
from rig.hal.frames import Found

CODES = {"i8": 2, "i16": 3, "i32": 4, "u8": 5, "u16": 6, "u32": 7}
BITS = {"i8": 8, "i16": 16, "i32": 32, "u8": 8, "u16": 16, "u32": 32}
NAMES = {code: name for name, code in CODES.items()}


class Drawn:
    """An EDS whose objects and mapping are drawn."""

    def __init__(self, profile, vendor, product, fixed):
        self.fixed = "ro" if fixed else "rw"
        self.sections = [
            f"[DeviceInfo]\nVendorNumber={vendor}\nProductNumber={product}\nGranularity=8\n"
        ]
        self.variable(0x1000, None, "u32", "ro", profile)

    def variable(self, index, sub, kind, access, default=None, mappable=False):
        section = f"{index:04X}" + ("" if sub is None else f"sub{sub:X}")
        said = "" if default is None else f"DefaultValue=0x{default:X}\n"
        self.sections.append(
            f"[{section}]\nParameterName=P{section}\nObjectType=0x7\nDataType=0x{CODES[kind]:04X}\n"
            f"AccessType={access}\n{said}PDOMapping={int(mappable)}\n"
        )

    def array(self, index, count):
        self.sections.append(
            f"[{index:04X}]\nParameterName=A{index:04X}\nObjectType=0x8\nSubNumber={count + 1}\n"
        )
        self.variable(index, 0, "u8", "ro", count)

    def pdo(self, base, entries):
        """Map (index, sub, type) into as many PDOs as they need."""
        frames, size = [[]], 0
        for entry in entries:
            if size + BITS[entry[2]] > 64:
                frames.append([])
                size = 0
            frames[-1].append(entry)
            size += BITS[entry[2]]
        for number, frame in enumerate(frames):
            parameters, mapping = base + number, base + 0x200 + number
            self.array(parameters, 2)
            self.variable(parameters, 1, "u32", "rw")
            self.variable(parameters, 2, "u8", "rw", 1)
            slots = len(frame) if self.fixed == "ro" else 8
            self.sections.append(
                f"[{mapping:04X}]\nParameterName=M\nObjectType=0x9\nSubNumber={slots + 1}\n"
            )
            self.variable(mapping, 0, "u8", self.fixed, len(frame))
            for k in range(slots):
                code = 0
                if k < len(frame):
                    index, sub, kind = frame[k]
                    code = index << 16 | sub << 8 | BITS[kind]
                self.variable(mapping, k + 1, "u32", self.fixed, code)

    def write(self, path):
        path.write_text("\n".join(self.sections))


def mapped_by_canopen(path, base):
    """Return what a file maps as shipped, as an independent library reads it."""
    dictionary, found = canopen.import_od(str(path)), []
    for number in range(4):
        record = dictionary.get(base + number)
        for sub in range(1, 1 + (record[0].default if record is not None else 0)):
            index, place = record[sub].default >> 16, record[sub].default >> 8 & 0xFF
            its = dictionary[index]
            kind = its if isinstance(its, canopen.objectdictionary.ODVariable) else its[place]
            found.append((index, place, NAMES[kind.data_type]))
    return found


def draw_encoder(path, rng, fixed):
    eds = Drawn(0x0196, 0x5A, 0x77, fixed)
    position = rng.choice([(0x6004, 0), (0x6020, 1), (0x6020, 2)])
    kind = rng.choice(["i32", "u32"])
    if position[1]:
        eds.array(position[0], position[1])
    eds.variable(*position[:1], position[1] or None, kind, "ro", mappable=True)
    sent = [(*position, kind)]
    if rng.random() < 0.6:
        sub, kind = rng.choice([1, 2]), "i16"
        eds.array(0x6030, sub)
        eds.variable(0x6030, sub, kind, "ro", mappable=True)
        sent.append((0x6030, sub, kind))
    if rng.random() < 0.5:
        eds.variable(0x6503, None, "u16", "ro", mappable=True)
        sent.append((0x6503, 0, "u16"))
    eds.pdo(0x1800, sent)
    eds.write(path)


def draw_module(path, rng, fixed):
    eds = Drawn(0x0191, 0x5B, 0x78, fixed)
    count, kind = rng.randint(2, 4), rng.choice(["i16", "u16"])
    for index, access in ((0x6411, "rw"), (0x6401, "ro")):
        eds.array(index, count)
        for sub in range(1, count + 1):
            eds.variable(index, sub, kind, access, mappable=True)
    for index, access in ((0x6200, "rw"), (0x6000, "ro")):
        eds.array(index, 1)
        eds.variable(index, 1, "u8", access, mappable=True)
    eds.array(0x6443, count)
    eds.array(0x6444, count)
    for sub in range(1, count + 1):
        eds.variable(0x6443, sub, "u8", "rw")
        eds.variable(0x6444, sub, "i32", "rw")
    outputs, inputs = (rng.sample(range(1, count + 1), 2) for _ in range(2))
    outputs, inputs = (rng.sample(range(1, count + 1), 2) for _ in range(2))
    setpoints = [(0x6411, sub, kind) for sub in outputs]
    echoes = setpoints if rng.random() < 0.5 or not fixed else []
    eds.pdo(0x1400, [*setpoints, (0x6200, 1, "u8")])
    eds.pdo(0x1800, [*((0x6401, sub, kind) for sub in inputs), *echoes, (0x6000, 1, "u8")])
    eds.write(path)


def answers(*_):
    identities = {0x10: (401, 0x5B, 0x78), 0x20: (406, 0x5A, 0x77), 0x21: (406, 0x5A, 0x77)}
    for node, (profile, vendor, product) in identities.items():
        yield Answer(
            "can0", node, "", Found(node, f"CiA {profile}", profile, vendor, product, (1,)), ()
        )


def scan(tmp_path, monkeypatch, *words):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("rig.scaffolding.scanned.survey_buses", lambda *a: list(answers(*a)))
    return invoke(["new", "rig", "mine", "--like", "cylinder", "--scan", "hardware", *words])


def mine():
    return load_profile("mine.yaml", REGISTRY, (), find_configs(None))


@pytest.mark.parametrize("fixed", [True, False], ids=["fixed", "free"])
@pytest.mark.parametrize("seed", range(8))
def test_an_encoder_sends_what_its_file_maps(tmp_path, monkeypatch, seed, fixed):
    eds = tmp_path / "encoder.eds"
    draw_encoder(eds, random.Random(f"encoder {seed}"), fixed)
    assert scan(tmp_path, monkeypatch, "--eds", "encoder.eds") == 0
    profile = mine()
    check_profile(profile)
    for name in ("encoder-agonist", "encoder-antagonist"):
        settings = profile.devices[name].settings
        assert settings.remap is not fixed
        sent = [(entry.object, entry.sub, entry.type) for entry in settings.transmit_entries]
        assert sent == mapped_by_canopen(eds, 0x1A00)


@pytest.mark.parametrize("seed", range(8))
def test_a_module_of_a_fixed_mapping_has_its_channels_in_that_order(tmp_path, monkeypatch, seed):
    eds = tmp_path / "module.eds"
    draw_module(eds, random.Random(f"module {seed}"), fixed=True)
    assert scan(tmp_path, monkeypatch, "--eds", "module.eds") == 0
    profile = mine()
    check_profile(profile)
    settings = profile.devices["regulators"].settings
    for entries, base in ((settings.receive_entries, 0x1600), (settings.transmit_entries, 0x1A00)):
        exchanged = [(entry.object, entry.sub, entry.type) for entry in entries]
        assert exchanged == mapped_by_canopen(eds, base)


@pytest.mark.parametrize("seed", range(4))
def test_a_module_whose_mapping_is_written_keeps_the_channels_of_one_like_it(
    tmp_path, monkeypatch, seed
):
    eds = tmp_path / "module.eds"
    draw_module(eds, random.Random(f"free {seed}"), fixed=False)
    assert scan(tmp_path, monkeypatch, "--eds", "module.eds") == 0
    profile = mine()
    check_profile(profile)
    channels = profile.devices["regulators"].settings.channels.values()
    assert [channel.setpoint.sub for channel in channels] == [1, 2]
    kinds = {kind for index, _, kind in mapped_by_canopen(eds, 0x1600) if index == 0x6411}
    assert {channel.setpoint.type for channel in channels} == kinds


def test_a_file_of_nobody_who_answers_is_told_and_not_taken(tmp_path, monkeypatch, capsys):
    Drawn(0x0192, 0, 0, fixed=True).write(tmp_path / "drive.eds")
    assert scan(tmp_path, monkeypatch, "--eds", "drive.eds") == 0
    assert "drive.eds is of nobody who answers" in capsys.readouterr().err
    assert "\n    eds:" not in (tmp_path / "mine.yaml").read_text()


def test_a_file_without_a_scan_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert invoke(["new", "rig", "mine", "--eds", "x.eds"]) == 2
    assert "--eds goes with --scan" in capsys.readouterr().err
