"""BLF files of strangers: none swells beyond what fits, and none has a reader stand still."""

import io
import struct
import zlib

import can
import pytest

from drivers.can.blf_file import check_blf

HEADER = 144


@pytest.fixture(scope="module")
def healthy(tmp_path_factory):
    path = tmp_path_factory.mktemp("blf") / "good.blf"
    with can.BLFWriter(path, max_container_size=2000) as writer:
        for k in range(500):  # several containers, with frames that begin in one and end in another
            data = k.to_bytes(8, "little")
            writer(can.Message(timestamp=1 + k * 1e-3, arbitration_id=0x181, data=data))
    return path.read_bytes()


def container(held, method=2, size=None):
    body = struct.pack("<H6xL4x", method, len(held)) + (zlib.compress(held) if method else held)
    size = 16 + len(body) if size is None else size
    return struct.pack("<4sHHLL", b"LOBJ", 16, 1, size, 10) + body + b"\0" * (size % 4)


def thing(size, kind=1, content=b"\0" * 32):
    return struct.pack("<4sHHLL", b"LOBJ", 32, 1, size, kind) + content


def test_what_tools_write_passes(healthy):
    assert healthy.count(b"LOBJ") > 5
    check_blf(io.BytesIO(healthy))
    for cut in range(0, len(healthy), 97):  # a file that was not finished is the reader's to judge
        check_blf(io.BytesIO(healthy[:cut]))


@pytest.mark.parametrize(
    ("objects", "said"),
    [
        (container(b"\0" * (1 << 25)), "swells to more than"),
        (container(thing(0)), "says that it has 0 bytes"),
        (container(thing(15)), "says that it has 15 bytes"),
        (container(thing(48) + thing(0), method=0), "says that it has 0 bytes"),
        (container(thing(0xFFFFFFFF)), "says that it has 4294967295 bytes"),
        (container(thing(48)[:20]) + container(thing(48)[20:] + thing(3)), "it has 3 bytes"),
        (thing(0), "says that it has 0 bytes"),
        (container(b"", size=8), "says that it has 8 bytes"),
        (container(b"x")[:32] + b"\xff" * 16, "cannot be read"),
    ],
)
def test_what_swells_or_has_no_size_is_refused(healthy, objects, said):
    with pytest.raises(ValueError, match=said):
        check_blf(io.BytesIO(healthy[:HEADER] + objects))
    with pytest.raises(ValueError, match=said):
        check_blf(io.BytesIO(healthy + objects))


@pytest.mark.parametrize("size", [0, 7, 0xFFFFFFFF])
def test_a_header_of_another_size_is_refused(healthy, size):
    with pytest.raises(ValueError, match="no header"):
        check_blf(io.BytesIO(healthy[:4] + struct.pack("<L", size) + healthy[8:]))
