"""How many objects go into a PDO, and how many PDOs a node has."""

import struct

import pytest

from drivers.canopen.mapping import RANGES, SIZES, STRUCT_CODES, Entry, layout_size, pack


def entries(*types):
    return [Entry(0x6000 + number, 1, kind) for number, kind in enumerate(types)]


@pytest.mark.parametrize(
    ("types", "sizes"),
    [
        ((), []),
        (("i16",) * 4, [8]),
        (("i16",) * 4 + ("u8",), [8, 1]),
        (("u8",) * 8, [8]),
        (("u8",) * 9, [8, 1]),
        (("f32", "u16", "u8", "u8"), [8]),
        (("f32", "u16", "u16", "u8"), [8, 1]),
        (("i32", "u8", "f32"), [5, 4]),  # in their order, even if others would fill the gap
        (("i32", "u8", "f32", "u16", "u8"), [5, 7]),
    ],
)
def test_objects_are_laid_into_as_few_pdos_as_their_order_permits(types, sizes):
    wanted = entries(*types)
    layouts = pack(wanted)
    assert [layout_size(layout) for layout in layouts] == sizes
    assert [entry for layout in layouts for entry in layout] == wanted


@pytest.mark.parametrize("first", [1, 2, 3, 4])
def test_a_node_has_four_pdos_in_either_direction(first):
    free = 5 - first
    assert len(pack(entries(*["i32"] * (2 * free)), first)) == free
    with pytest.raises(ValueError, match="5 PDOs would be needed, a node has 4"):
        pack(entries(*["i32"] * (2 * free), "u8"), first)


def test_an_entry_is_coded_as_its_mapping_object_holds_it():
    assert Entry(0x6443, 0x02, "i16").code == 0x64430210
    assert Entry(0x6000, 0x01, "u8").code == 0x60000108
    assert str(Entry(0x6443, 0x02, "f32")) == "0x6443:02"


def test_sizes_codes_and_ranges_are_of_one_table():
    packers = {kind: struct.Struct("<" + code) for kind, code in STRUCT_CODES.items()}
    assert {kind: packer.size for kind, packer in packers.items()} == SIZES
    for kind, (low, high) in RANGES.items():
        for value in (low, high):
            assert packers[kind].unpack(packers[kind].pack(value)) == (value,)
        for value in (low - 1, high + 1):
            with pytest.raises(struct.error):
                packers[kind].pack(value)
