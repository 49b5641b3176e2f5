"""The EDS files of the emulated devices: as the nodes are, and as others' tools read them."""

import configparser
import re
from pathlib import Path

import pytest

canopen = pytest.importorskip("canopen")

from eds_writer.description import NODES, describe  # noqa: E402
from test_cia402_under_canopen import LiveDrive  # noqa: E402
from test_emulated_under_canopen import ENCODER, REGULATORS, LiveRig, wait_until  # noqa: E402

FOLDER = Path(__file__).parents[2] / "configs" / "eds"
OD = canopen.objectdictionary
NODE = 5  # of the drive
# What a running node changes by itself, or has of its own.
OWN = {(0x1008, 0), (0x1018, 4), (0x1003, 0), (0x6401, 1), (0x6401, 2), (0x6004, 0), (0x6000, 1)}
# Of the joint that the profile describes, not of the kind of drive.
SCALES = {(index, sub) for index in (0x608F, 0x6091, 0x6092) for sub in (1, 2)} | {
    (0x6084, 0), (0x6085, 0), (0x6041, 0), (0x6064, 0), (0x6002, 0),
}  # fmt: skip
READ_ONLY, NO_DATA = 0x0601_0002, 0x0800_0024
# A transfer that was refused is closed again when it is forgotten, which Python tells from 3.13 on.
pytestmark = pytest.mark.filterwarnings(
    "ignore:Exception ignored in. <canopen.sdo.client:pytest.PytestUnraisableExceptionWarning"
)


@pytest.mark.parametrize("kind", NODES)
def test_the_files_are_those_that_the_nodes_write(kind):
    written = (FOLDER / f"{kind}.eds").read_text(encoding="ascii")
    assert written == describe(kind), "the node has changed: python tests/eds_writer configs/eds"


@pytest.mark.filterwarnings("ignore:datetime.datetime.utcnow:DeprecationWarning")  # from 3.12 on
@pytest.mark.parametrize("kind", NODES)
def test_canopen_exports_what_it_imports(kind, tmp_path):
    path = tmp_path / "again.eds"
    first = canopen.import_od(str(FOLDER / f"{kind}.eds"), NODE)
    with path.open("w") as target:
        canopen.export_od(first, target, "eds")
    second = canopen.import_od(str(path), NODE)
    assert describe_dictionary(first) == describe_dictionary(second)


def describe_dictionary(dictionary):
    return {
        (item.index, item.subindex): (item.data_type, item.access_type, item.default)
        for item in variables(dictionary)
    }


def variables(dictionary):
    for item in dictionary.values():
        if item.index < 0x1000:
            continue  # dummies
        yield from [item] if isinstance(item, OD.ODVariable) else item.values()


@pytest.mark.parametrize("kind", NODES)
def test_the_lists_of_a_file_are_those_of_its_sections(kind):
    """CiA 306-1, section 4.6.3: three lists, numbered from 1, of all objects that are described.

    `canopen` reads the sections and not the lists, `configparser` knows nothing of either.
    """
    file = configparser.ConfigParser(interpolation=None)
    file.read(FOLDER / f"{kind}.eds", encoding="ascii")
    listed = []
    for name in ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"):
        numbered = dict(file[name])
        count = int(numbered.pop("supportedobjects"))
        assert list(numbered) == [str(number) for number in range(1, count + 1)]
        listed += [int(index, 16) for index in numbered.values()]
    assert {0x1000, 0x1001, 0x1018} <= set(listed)
    assert len(set(listed)) == len(listed)
    assert sorted(listed) == sorted(
        int(name, 16) for name in file.sections() if re.fullmatch("[0-9A-Fa-f]{4}", name)
    )
    for index in listed:
        subs = [n for n in file.sections() if n.lower().startswith(f"{index:04x}sub")]
        said = int(file[f"{index:04X}"].get("SubNumber", "0"), 0)
        assert len(subs) == said, hex(index)
        assert said or "DataType" in file[f"{index:04X}"]


def read_back(sdo, dictionary, skipped, frames, record_property, who):
    """Read every object of the EDS; write what may be written; be refused elsewhere."""
    before = len(frames)
    values = []
    for item in variables(dictionary):
        where = item.index, item.subindex
        if item.index == 0x1003 and item.subindex:
            # CiA 301, 7.5.2.4: a field that holds no error yet has no data to give.
            with pytest.raises(canopen.SdoAbortedError) as refusal:
                sdo.upload(*where)
            assert refusal.value.code == NO_DATA
            values.append((item, bytes(4)))
            continue
        raw = sdo.upload(*where)
        values.append((item, raw))
        if item.data_type != OD.VISIBLE_STRING:
            assert len(raw) == len(item.encode_raw(0)), f"{where}: another size than the EDS says"
        if where not in skipped and item.default is not None:
            assert item.decode_raw(raw) == item.default, f"{item.name} {where[0]:04X}:{where[1]}"
    written = refused = 0
    for item, raw in values:  # after all were read: a preset moves the offset
        where = item.index, item.subindex
        if item.access_type in ("ro", "const"):
            with pytest.raises(canopen.SdoAbortedError) as refusal:
                sdo.download(*where, raw)
            assert refusal.value.code == READ_ONLY
            refused += 1
        elif not 0x1400 <= item.index < 0x1C00:
            sdo.download(*where, raw)
            written += 1
    record_property("exchanges", (who, len(frames) - before))
    return len(values), written, refused


@pytest.mark.parametrize(
    ("kind", "node"), [("cia401-analogue", REGULATORS), ("cia406-linear", ENCODER)]
)
def test_every_object_of_the_eds_is_there_and_as_it_says(kind, node, request, record_property):
    with LiveRig(request.node.name) as live:
        dictionary = canopen.import_od(str(FOLDER / f"{kind}.eds"), node)
        has = {(item.index, item.sub) for item in live.nodes[node == ENCODER].dictionary}
        assert has == {(item.index, item.subindex) for item in variables(dictionary)}
        read, written, refused = read_back(
            live.remotes[node].sdo,
            dictionary,
            OWN | SCALES,
            live.frames,
            record_property,
            "emulated nodes under canopen",
        )
    assert read == len(has)
    assert written > 10
    assert refused > 30


def test_every_object_of_the_drives_eds_is_there_and_as_it_says(request, record_property):
    with LiveDrive(request.node.name) as live:
        dictionary = canopen.import_od(str(FOLDER / "cia402-servo.eds"), NODE)
        has = {(item.index, item.sub) for item in live.node.dictionary}
        assert has == {(item.index, item.subindex) for item in variables(dictionary)}
        read, written, refused = read_back(
            live.master.sdo,
            dictionary,
            OWN | SCALES,
            live.frames,
            record_property,
            "emulated nodes under canopen",
        )
    assert read == len(has)
    assert written > 20
    assert refused > 30


def test_canopen_remaps_by_the_eds_alone(request, record_property):
    """`canopen` knows the module from its EDS only, and maps by its own procedure."""
    with LiveRig(request.node.name) as live:
        node = canopen.RemoteNode(REGULATORS, str(FOLDER / "cia401-analogue.eds"))
        node.sdo.RESPONSE_TIMEOUT = 5.0
        live.network.add_node(node)
        for pdos in (node.tpdo, node.rpdo):
            pdos.read()
        assert next(item.name for item in node.tpdo[2]).endswith("AnalogueInput 1")
        for pdo, indices in (
            (node.tpdo[1], (0x6401, 0x6401, 0x6000)),
            (node.rpdo[1], (0x6411, 0x6411, 0x6200)),
        ):
            pdo.clear()
            for index, sub in zip(indices, (1, 2, 1), strict=True):
                pdo.add_variable(index, sub)
            pdo.trans_type = 1
            pdo.enabled = True
            pdo.save()
        received = []
        node.tpdo[1].add_callback(lambda pdo: received.append([item.raw for item in pdo]))
        node.nmt.state = "OPERATIONAL"
        wait_until(lambda: live.nodes[0].state == 5)
        for item, raw in zip(node.rpdo[1], (0x4000, 0x2000, 1), strict=True):
            item.raw = raw
        node.rpdo[1].transmit()
        live.network.sync.transmit()
        wait_until(lambda: live.plant.supply)
        live.network.sync.transmit()
        wait_until(lambda: len(received) >= 2)
        assert received[-1] == [0x4000, 0x2000, 1]
        record_property("exchanges", ("emulated nodes under canopen", len(live.frames)))


def test_lss_is_not_offered_and_the_eds_says_so():
    for kind in NODES:
        text = (FOLDER / f"{kind}.eds").read_text()
        assert "LSS_Supported=0" in text
