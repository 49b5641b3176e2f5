"""A device's own EDS in a profile: what it adds, and what it refuses before a bus is opened."""

import re
from pathlib import Path

import pytest

from rig.assembly import REGISTRY, check_profile
from rig.cli import invoke
from rig.config import ProfileError, dump_resolved, load_profile

CONFIGS = Path(__file__).parents[3] / "configs"
EDS = {name: (CONFIGS / "eds" / f"{name}.eds").read_text() for name in
       ("cia401-analogue", "cia406-linear", "cia402-servo")}  # fmt: skip


def profile(tmp_path, text, *options):
    path = tmp_path / "mine.yaml"
    path.write_text(text)
    made = load_profile(path, REGISTRY, options, [CONFIGS])
    check_profile(made)
    return made


def cylinder(tmp_path, eds, device="regulators", extra=""):
    (tmp_path / "device.eds").write_text(eds)
    lines = f"extends: cylinder\ndevices:\n  {device}:\n    eds: device.eds\n{extra}"
    return profile(tmp_path, lines)


def refused(tmp_path, eds, device, extra=""):
    with pytest.raises(ProfileError) as caught:
        cylinder(tmp_path, eds, device, extra)
    return str(caught.value)


def without(eds, *sections):
    for section in sections:
        eds = re.sub(rf"\[{section}\]\n(?:[^\n]+\n)*\n", "", eds, flags=re.IGNORECASE)
    return eds


def changed(eds, section, key, value):
    made, count = re.subn(
        rf"(\[{section}\]\n(?:[^\n]+\n)*?{key}=)[^\n]*", rf"\g<1>{value}", eds, flags=re.IGNORECASE
    )
    assert count == 1
    return made


@pytest.mark.parametrize(
    ("rig", "device", "eds"),
    [
        ("cylinder", "regulators", "cia401-analogue"),
        ("cylinder", "encoder-agonist", "cia406-linear"),
        ("joint", "regulators", "cia401-analogue"),
        ("arm", "drives", "cia402-servo"),
        ("legs-can", "left-leg", "cia402-servo"),
    ],
)
def test_our_rigs_ask_nothing_of_the_emulated_devices_that_they_cannot(rig, device, eds):
    option = f"devices.{device}.eds={CONFIGS / 'eds' / eds}.eds"
    made = load_profile(rig, REGISTRY, [option], [CONFIGS])
    check_profile(made)
    assert made.devices[device].eds == CONFIGS / "eds" / f"{eds}.eds"


def test_types_come_from_the_file_unless_the_profile_says_them(tmp_path):
    eds = EDS["cia401-analogue"]
    for sub in (1, 2):
        eds = changed(eds, f"6411sub{sub}", "DataType", "0x0006")
        eds = changed(eds, f"6443sub{sub}", "DataType", "6")
    settings = cylinder(tmp_path, eds).devices["regulators"].settings
    assert [channel.setpoint.type for channel in settings.channels.values()] == ["u16", "u16"]
    assert settings.channels["agonist"].monitor.type == "i16"
    assert settings.error_mode_type == "u16"
    text = refused(
        tmp_path, eds, "regulators", "    channels:\n      agonist: {setpoint: {type: i16}}\n"
    )
    assert "mine.yaml:6:34: regulators: object 0x6411:01 is u16, not i16" in text
    assert re.search(r"device\.eds:\d+\)", text)


def test_a_range_that_only_the_files_type_can_hold_is_accepted(tmp_path):
    eds = changed(EDS["cia401-analogue"], "6411sub1", "DataType", "0x0006")
    extra = "    channels:\n      agonist: {setpoint: {raw: [0, 65535]}}\n"
    made = cylinder(tmp_path, eds, extra=extra).devices["regulators"].settings
    assert made.channels["agonist"].setpoint.type == "u16"


@pytest.mark.parametrize(
    ("device", "edit", "extra", "message"),
    [
        (
            "encoder-agonist",
            lambda eds: without(eds, "6030sub1"),
            "",
            r"mine\.yaml:4:10: encoder-agonist: .*device\.eds has no object 0x6030:01, which TPDO1",
        ),
        (
            "encoder-agonist",
            lambda eds: eds,
            "    speed: {index: 0x6509, sub: 0}\n    alarms: polled\n",
            r"mine\.yaml:5:5: encoder-agonist: object 0x6509:00 cannot be mapped .*device\.eds:\d+",
        ),
        (
            "encoder-agonist",
            lambda eds: changed(eds, "6004", "AccessType", "wo"),
            "",
            r"object 0x6004:00 is wo and cannot be sent in TPDO1",
        ),
        (
            "regulators",
            lambda eds: changed(eds, "6411sub1", "AccessType", "ro"),
            "",
            r"cylinder\.yaml:\d+:\d+: regulators: object 0x6411:01 is ro and cannot be received",
        ),
        (
            "regulators",
            lambda eds: without(eds, "1400sub5"),
            "    setpoint_deadline: 5 ms\n",
            r"mine\.yaml:5:24: regulators: .*device\.eds has no deadline of RPDO1 \(0x1400:05\)",
        ),
        (
            "regulators",
            lambda eds: changed(eds, "1400sub5", "AccessType", "ro"),
            "    setpoint_deadline: 5 ms\n",
            r"the deadline of RPDO1 cannot be set \(.*device\.eds:\d+\)",
        ),
        (
            "regulators",
            lambda eds: without(eds, *(f"1A00sub{k}" for k in range(3, 9))),
            "",
            r"cylinder\.yaml:\d+:\d+: regulators: TPDO1 can map 2 objects at most, not 4",
        ),
        (
            "regulators",
            lambda eds: changed(eds, "DeviceInfo", "Granularity", "16"),
            "",
            r"object 0x6000:01 has 8 bits, but the device maps in steps of 16",
        ),
        (
            "encoder-agonist",
            lambda eds: without(eds, "1800", *(f"1800sub{k}" for k in (0, 1, 2, 3, 5))),
            "",
            r"device\.eds has no TPDO1 \(0x1800\)",
        ),
        (
            "encoder-agonist",
            lambda eds: changed(
                changed(eds, "1800sub1", "AccessType", "const"), "1800sub1", "DefaultValue", "0x1C0"
            ),
            "",
            r"TPDO1 has the identifier 0x000001C0, which cannot be changed, and 0x1A0 is needed",
        ),
        (
            "encoder-agonist",
            lambda eds: changed(eds, "1800sub2", "AccessType", "ro"),
            "",
            r"TPDO1 has transmission type 254, which cannot be changed, and 1 is needed",
        ),
        (
            "encoder-agonist",
            lambda eds: changed(eds, "6030sub1", "DataType", "0x0004"),
            "    speed: {index: 0x6030}\n",
            r"more than the 8 bytes of one PDO",
        ),
    ],
    ids=[
        "absent", "not mappable", "not readable", "not writable", "no deadline", "fixed deadline",
        "too many", "granularity",
        "no PDO", "identifier", "transmission type", "too long",
    ],
)  # fmt: skip
def test_what_the_device_cannot_do_is_refused_where_the_profile_asks_for_it(
    device, edit, extra, message, tmp_path
):
    base = {"regulators": "cia401-analogue", "encoder-agonist": "cia406-linear"}[device]
    text = refused(tmp_path, edit(EDS[base]), device, extra)
    assert re.search(message, text), text


def fixed_mapping(eds):
    for kind in ("1600", "1A00"):
        for number in range(4):
            index = f"{int(kind, 16) + number:04X}"
            for sub in range(9):
                eds = changed(eds, f"{index}sub{sub}", "AccessType", "const")
    return eds


def test_a_fixed_mapping_is_compared_and_not_written(tmp_path):
    eds = fixed_mapping(EDS["cia406-linear"])
    text = refused(tmp_path, eds, "encoder-agonist")
    assert "TPDO1 cannot be changed: it is 60040020, and 60040020 60300110 65030010" in text
    extra = "    speed: null\n    alarms: polled\n"
    made = cylinder(tmp_path, eds, "encoder-agonist", extra).devices["encoder-agonist"]
    assert made.settings.remap is False
    text = refused(tmp_path, eds, "encoder-agonist", extra + "    remap: true\n")
    assert re.search(r"mine\.yaml:7:12: .*mapping of TPDO1 cannot be written", text)


def test_a_drive_without_the_object_is_refused_at_the_feedback_that_needs_it(tmp_path):
    (tmp_path / "drive.eds").write_text(without(EDS["cia402-servo"], "6077"))
    with pytest.raises(ProfileError, match=r"has no object 0x6077:00, which TPDO2") as caught:
        profile(tmp_path, "extends: arm\ndevices:\n  drives:\n    eds: drive.eds\n")
    assert len(caught.value.diagnostics) == 1, "six drives have one feedback"


def test_every_error_of_profile_and_device_comes_at_once(tmp_path):
    text = refused(
        tmp_path, without(EDS["cia406-linear"], "6503"), "encoder-agonist", "    max_speed: fast\n"
    )
    assert "max_speed" in text
    extra = "    speed: {index: 0x6509, sub: 0, type: i16}\n"
    text = refused(tmp_path, without(EDS["cia406-linear"], "6503"), "encoder-agonist", extra)
    assert text.endswith("3 errors")


def test_a_broken_or_missing_file_is_named_at_the_key(tmp_path):
    text = refused(tmp_path, EDS["cia406-linear"].replace("[6004]", "[6004"), "encoder-agonist")
    assert re.match(rf"{tmp_path}/mine\.yaml:4:10: {tmp_path}/device\.eds:\d+: a section's", text)
    with pytest.raises(
        ProfileError, match=r"mine\.yaml:4:10: cannot read .*nowhere\.eds: No such file"
    ):
        profile(tmp_path, "extends: cylinder\ndevices:\n  regulators:\n    eds: nowhere.eds\n")


def test_an_eds_of_the_wrong_driver_is_an_unknown_key(tmp_path):
    with pytest.raises(ProfileError, match="unknown key 'eds'"):
        profile(tmp_path, "extends: arm-odrive\ndevices:\n  drives:\n    eds: x.eds\n")


def test_the_resolved_profile_names_the_copy_in_the_run_folder(tmp_path):
    made = cylinder(tmp_path, EDS["cia401-analogue"])
    text = dump_resolved(made)
    assert "eds: eds/regulators.eds" in text
    (tmp_path / "eds").mkdir()
    (tmp_path / "eds" / "regulators.eds").write_text(EDS["cia401-analogue"])
    (tmp_path / "profile.yaml").write_text(text)
    again = load_profile(tmp_path / "profile.yaml", REGISTRY, (), [CONFIGS])
    assert again.devices["regulators"].settings.channels == (
        made.devices["regulators"].settings.channels
    )


def test_the_command_line_ends_with_2_and_opens_nothing(tmp_path, capfd):
    (tmp_path / "device.eds").write_text(without(EDS["cia401-analogue"], "6401sub2"))
    option = f"devices.regulators.eds={tmp_path / 'device.eds'}"
    arguments = ["run", "cylinder-step", "--on", "nowhere0", "--out", str(tmp_path)]
    assert invoke([*arguments, "--set", option]) == 2
    assert "has no object 0x6401:02" in capfd.readouterr().err
    assert not list(tmp_path.glob("*nowhere*"))
