"""EDS files with other people's habits: read alike, or refused with file and line."""

from pathlib import Path

import pytest

from drivers.canopen.eds import EdsError, decode_text, read_eds
from rig.hal import ConfigurationError

CONFIGS = Path(__file__).parents[2] / "configs" / "eds"
SHIPPED = sorted(CONFIGS.glob("*.eds"))

PLAIN = """\
[DeviceInfo]
VendorNumber=0x2A
Granularity=8

[1800]
ParameterName=TPDO1
ObjectType=0x9
SubNumber=3

[1800sub0]
ParameterName=Highest
ObjectType=0x7
DataType=0x0005
AccessType=const
DefaultValue=2
PDOMapping=0

[1800sub1]
ParameterName=COB-ID
DataType=0x0007
AccessType=rw
DefaultValue=$NODEID+0x40000180

[1800sub2]
ParameterName=Type
DataType=0x0005
AccessType=rw
DefaultValue=255

[6401]
ParameterName=Inputs
ObjectType=0x8
CompactSubObj=3
DataType=0x0003
AccessType=ro
DefaultValue=0
PDOMapping=1

[6401Name]
NrOfEntries=1
2=Pressure

[6401Value]
NrOfEntries=1
3=0x10

[6503]
ParameterName=Alarms
DataType=0x0006
AccessType=ro
PDOMapping=1
"""

HABITS = {
    "as it should be": lambda text: text,
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "old Macintosh lines and a byte order mark": lambda text: "\ufeff" + text.replace("\n", "\r"),
    "lower case": str.lower,
    "upper case": str.upper,
    "decimal numbers": lambda text: (
        text.replace("0x0003", "3").replace("0x0005", "5").replace("0x0007", "7")
        .replace("0x0006", "6").replace("0x40000180", "1073742208").replace("0x9", "9")
        .replace("0x8", "8").replace("0x7", "7").replace("0x10", "16").replace("0x2A", "42")
    ),
    "octal and leading zeros": lambda text: text.replace("=255", "=0377").replace("=2\n", "=002\n"),
    "the node number last": lambda text: text.replace(
        "$NODEID+0x40000180", "0x40000180 + $NodeId"
    ),
    "spaces": lambda text: text.replace("=", " = ").replace("[", "[ ").replace("]", " ]"),
    "comments": lambda text: "; from a tool\n" + text.replace("=rw\n", "=rw ; a comment\n"),
    "two-digit sub-indices": lambda text: text.replace("sub", "sub0"),
    "no DeviceInfo": lambda text: text[text.index("[1800]") :],
    "no ObjectType": lambda text: text.replace("ObjectType=0x7\n", ""),
    "no empty lines": lambda text: text.replace("\n\n", "\n"),
    "a zero byte of CP/M at the end": lambda text: text + "\x1a",
}  # fmt: skip


def write(tmp_path, text):
    path = tmp_path / "device.eds"
    path.write_bytes(text.encode("utf-8"))
    return path


@pytest.mark.parametrize("habit", HABITS)
def test_habits_of_other_tools_make_no_difference(habit, tmp_path):
    eds = read_eds(write(tmp_path, HABITS[habit](PLAIN)))
    cob_id = eds.find(0x1800, 1)
    assert (cob_id.type, cob_id.access, cob_id.mappable) == ("u32", "rw", False)
    assert eds.default_of(cob_id, 5) == 0x40000185
    assert eds.default_of(eds.find(0x1800, 2), 5) == 255
    assert eds.default_of(eds.find(0x1800, 0), 5) == 2
    second, third = eds.find(0x6401, 2), eds.find(0x6401, 3)
    assert (second.type, second.mappable, second.name.lower()) == ("i16", True, "pressure")
    assert (eds.default_of(second, 5), eds.default_of(third, 5)) == (0, 16)
    assert eds.default_of(eds.find(0x6401, 0), 5) == 3
    assert eds.find(0x6401, 4) is None
    assert (eds.find(0x6503, 0).type, eds.find(0x6503, 1)) == ("u16", None)
    assert eds.default_of(eds.find(0x6503, 0), 5) is None
    assert eds.find(0x6004, 0) is None
    assert eds.device_number("Granularity", 8) == 8


def test_latin_1_is_read():
    assert decode_text("Größe".encode("latin-1")) == "Größe"


@pytest.mark.parametrize(
    ("change", "line", "what"),
    [
        (("[1800sub2]", "[1800sub1]"), 24, r"section \[1800sub1\] is in line 18 already"),
        (("[1800sub2]", "[1800sub2"), 24, "a section's name has no end"),
        (("VendorNumber=0x2A", "VendorNumber"), 2, r"expected \[section\] or name=value"),
        (("[DeviceInfo]\n", "Device=1\n"), 1, r"expected \[section\] or name=value"),
    ],
)
def test_what_is_no_eds_file_is_refused_with_the_line(change, line, what, tmp_path):
    path = write(tmp_path, PLAIN.replace(*change))
    with pytest.raises(EdsError, match=rf"^{path}:{line}: .*{what}") as caught:
        read_eds(path)
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("change", "line", "what"),
    [
        (("DataType=0x0006\n", ""), 47, "object 0x6503:00 has no DataType"),
        (("DataType=0x0006", "DataType=WORD"), 49, "DataType is 'WORD', expected a number"),
        (("AccessType=ro\nPDO", "AccessType=read\nPDO"), 50, "AccessType of 0x6503:00 is 'read'"),
    ],
)
def test_a_mistake_matters_only_to_who_needs_the_object(change, line, what, tmp_path):
    path = write(tmp_path, PLAIN.replace(*change))
    eds = read_eds(path)
    assert eds.find(0x1800, 1) is not None
    with pytest.raises(EdsError, match=rf"{path}:{line}: {what}"):
        eds.find(0x6503, 0)
    assert eds.name_of(0x6503, 0) is None


@pytest.mark.parametrize("count", ["255", "1000000000", "-1", "0xFFFFFFFFFFFFFFFF"])
def test_an_array_of_more_elements_than_an_object_has_is_refused(count, tmp_path):
    eds = read_eds(write(tmp_path, PLAIN.replace("CompactSubObj=3", f"CompactSubObj={count}")))
    with pytest.raises(EdsError, match=r":33: CompactSubObj is .*, expected 0 to 254"):
        list(eds.objects())
    with pytest.raises(EdsError, match="expected 0 to 254"):
        eds.find(0x6401, 1)


def test_a_file_without_objects_and_a_missing_one_are_named(tmp_path):
    path = write(tmp_path, "[FileInfo]\nFileName=x\n")
    with pytest.raises(EdsError, match="describes no object"):
        read_eds(path)
    with pytest.raises(ConfigurationError, match=r"cannot read .*nowhere\.eds: No such file"):
        read_eds(tmp_path / "nowhere.eds")


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_we_read_what_canopen_reads(path):
    """Two readers that share nothing: every object, type, access, mapping and default."""
    canopen = pytest.importorskip("canopen")
    types = {2: "i8", 3: "i16", 4: "i32", 5: "u8", 6: "u16", 7: "u32", 1: "bool", 9: "text"}
    eds, theirs = read_eds(path), canopen.import_od(str(path), 0x15)
    compared = 0
    single = canopen.objectdictionary.ODVariable
    for item in theirs.values():
        if item.index < 0x1000:
            continue  # dummies, which are no objects of the device
        for variable in [item] if isinstance(item, single) else item.values():
            ours = eds.find(variable.index, variable.subindex)
            assert ours.type == types[variable.data_type]
            assert ours.access == variable.access_type
            assert ours.mappable == variable.pdo_mappable
            if variable.data_type != 9:
                assert eds.default_of(ours, 0x15) == variable.default
            compared += 1
    assert compared > 100
