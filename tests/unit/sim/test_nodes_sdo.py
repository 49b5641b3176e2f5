"""The SDO server, byte by byte (CiA 301 section 7.2.4), and the object dictionary's rules."""

import pytest
from emulated_rig import AGONIST, REGULATORS

# request to 0x610, answer from 0x590
EXPEDITED = [
    pytest.param("4000100000000000", "4300100091010F00", id="upload u32"),
    pytest.param("4001100000000000", "4F01100000000000", id="upload u8"),
    pytest.param("4017100000000000", "4B17100000000000", id="upload u16"),
    pytest.param("2B116401FF2F0000", "6011640100000000", id="download i16"),
    pytest.param("2F29100102000000", "6029100100000000", id="download u8"),
    pytest.param("2211640134120000", "6011640100000000", id="download without a size"),
    pytest.param("2344640100800000", "6044640100000000", id="download i32"),
]

ABORTS = [
    pytest.param("4099990000000000", "8099990000000206", id="no object"),
    pytest.param("4000100100000000", "8000100111000906", id="no sub-index"),
    pytest.param("2300100000000000", "8000100002000106", id="read-only"),
    pytest.param("2B01640100000000", "8001640102000106", id="read-only input"),
    pytest.param("2F11640100000000", "8011640110000706", id="too short"),
    pytest.param("2311640100000000", "8011640110000706", id="too long"),
    pytest.param("2F43640102000000", "8043640130000906", id="out of range"),
    pytest.param("2F23640002000000", "8023640030000906", id="boolean of 2"),
    pytest.param("2F29100103000000", "8029100130000906", id="unknown error behaviour"),
    pytest.param("2F03100001000000", "8003100030000906", id="error history only takes 0"),
    pytest.param("4003100100000000", "8003100124000008", id="error history is empty"),
    pytest.param("2316100100008101", "8016100130000906", id="consumer entry of node 129+"),
    pytest.param("6000000000000000", "8000000001000405", id="segment of no transfer"),
    pytest.param("0000000000000000", "8000000001000405", id="download segment of none"),
    pytest.param("A000100000000000", "8000000001000405", id="block upload"),
    pytest.param("2305100080000040", "8005100030000906", id="SYNC producer"),
]


@pytest.mark.parametrize(("request_", "answer"), EXPEDITED)
def test_expedited_transfer(bench, request_, answer):
    bench.run()
    assert bench.ask(f"610#{request_}") == [f"590#{answer}"]


@pytest.mark.parametrize(("request_", "answer"), ABORTS)
def test_abort(bench, request_, answer):
    bench.run()
    assert bench.ask(f"610#{request_}") == [f"590#{answer}"]


def test_segmented_upload_toggles_and_ends(bench):
    bench.run()
    name = b"emulated regulators"
    assert bench.ask("610#4008100000000000") == [f"590#41081000{len(name):02X}000000"]
    parts = [bench.ask(f"610#{command}00000000000000")[0][4:] for command in ("60", "70", "60")]
    assert [part[:2] for part in parts] == ["00", "10", "05"]
    assert b"".join(bytes.fromhex(part)[1:] for part in parts).rstrip(b"\0") == name


def test_segmented_upload_refuses_a_wrong_toggle(bench):
    bench.run()
    bench.ask("610#4008100000000000")
    assert bench.ask("610#7000000000000000") == ["590#8008100000000305"]


def test_segmented_download_of_a_number(bench):
    bench.run()
    assert bench.ask("610#2144640104000000") == ["590#6044640100000000"]
    assert bench.ask("610#0778563412000000") == ["590#2000000000000000"]
    assert bench.read(REGULATORS, 0x6444, 1) == 0x12345678


def test_segmented_download_refuses_a_length_that_does_not_fit_the_type(bench):
    bench.run()
    assert bench.ask("610#2144640105000000") == ["590#8044640110000706"]


def test_transfer_that_stops_is_aborted(bench):
    bench.run()
    bench.ask("610#4008100000000000")
    assert bench.run(0.9) == []
    assert bench.run(0.2) == ["590#8008100000000405"]


def test_short_requests_and_foreign_frames_are_ignored(bench):
    bench.run()
    for frame, kind in (
        ("610#40001000000000", {}),
        ("610#4000100000000000", {"extended": True}),
        ("610#4000100000000000", {"remote": True}),
        ("610#4000100000000000", {"error": True}),
        ("630#4000100000000000", {}),
        ("7E5#0102030405060708", {}),
    ):
        bench.put(frame, **kind)
    assert bench.run() == []


def test_no_sdo_when_stopped(bench):
    bench.run()
    bench.ask("000#0210")
    assert bench.ask("610#4000100000000000") == []
    assert bench.ask("000#8010", "610#4000100000000000") == ["590#4300100091010F00"]


def test_preset_is_refused_outside_pre_operational(bench):
    bench.start()
    assert bench.write(AGONIST, 0x6003, 0, 5000, 4) == 0x08000022
    bench.ask("000#8000")
    assert bench.write(AGONIST, 0x6003, 0, 5000, 4) == 0
    assert bench.read(AGONIST, 0x6004) == 5000


def test_every_object_can_be_read_or_says_why(bench):
    bench.run()
    for node in (bench.regulators, bench.agonist):
        for variable in list(node.dictionary):
            answer = bench.ask(
                f"{0x600 + node.node_id:03X}#40"
                f"{variable.index & 0xFF:02X}{variable.index >> 8:02X}{variable.sub:02X}00000000"
            )[0]
            empty_history = variable.index == 0x1003 and variable.sub > 0
            assert answer[4] == ("8" if empty_history else "4"), (variable.index, answer)
