"""Files of readings: what is right is SI, what is wrong is named with line and column."""

import pytest

from rig.calibration.instrument_files import read_file
from rig.calibration.instruments import Instrument
from rig.hal import ConfigurationError

HAND = [
    Instrument(f"hand {axis}", "m", 50e-6, ("pose 1", "pose 2"), f"marker_{axis}") for axis in "xy"
]
JIG = Instrument("angle right_knee", "rad", 1e-3, ("straight",), "right_knee", (0.5,))

TABLE = "stretch,hand x (mm),hand y (m)\npose 1,400.5,-0.1\npose 2,1,2\n"


@pytest.fixture
def read(tmp_path):
    def of(text, instruments=HAND):
        path = tmp_path / "readings.csv"
        path.write_text(text, encoding="utf-8")
        return read_file(instruments, path)

    return of


def test_a_table_with_units_in_its_head(read):
    found = read("# laser tracker, 21 degC\n" + TABLE)
    assert found["hand x"] == {"pose 1": pytest.approx(0.4005), "pose 2": pytest.approx(1e-3)}
    assert found["hand y"] == {"pose 1": -0.1, "pose 2": 2.0}


def test_a_line_for_each_reading(read):
    found = read("hand x,pose 1,400.5 mm\nhand y,pose 1,0.2\n")
    assert found == {"hand x": {"pose 1": pytest.approx(0.4005)}, "hand y": {"pose 1": 0.2}}


def test_what_a_jig_is_made_to_needs_no_reading_and_may_have_one(read):
    assert read("", [JIG]) == {"angle right_knee": {"straight": 0.5}}
    found = read("angle right_knee,straight,30 deg\n", [JIG])
    assert found["angle right_knee"]["straight"] == pytest.approx(0.5235988)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (TABLE.replace("(mm)", "(kg)"), "readings.csv:1:9: "),
        (TABLE.replace("hand y", "hand yy"), "1:21: no quantity is called 'hand yy'; did you mean"),
        (TABLE.replace("-0.1", "far"), "2:14: "),
        (TABLE.replace("-0.1", "nan"), "2:14: 'nan m' does not start with a number"),
        (TABLE.replace("pose 2", "pose 3"), "3:1: no stretch is called 'pose 3'; did you mean"),
        (TABLE.replace(",2\n", "\n"), "3:8: 2 columns, the head has 3"),
        ("hand x,pose 1,30 deg\n", "1:15: "),
        ("hand x;pose 1;0.4\n", "1:1: expected quantity,stretch,value"),
    ],
)
def test_what_is_wrong_is_named_with_line_and_column(read, text, said):
    with pytest.raises(ConfigurationError) as caught:
        read(text)
    assert said in str(caught.value)


def test_a_file_that_fills_the_memory_is_refused(tmp_path):
    path = tmp_path / "readings.csv"
    with path.open("wb") as stream:
        stream.truncate(1 << 33)
    with pytest.raises(ConfigurationError, match="it has more than 4194304 bytes"):
        read_file(HAND, path)
