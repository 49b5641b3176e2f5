"""Files of motions that are no files, or too long, are refused and never waited for."""

import os

import pytest

from controllers.arm.online.twist_file import read_rows
from controllers.arm.places.poses import read_poses
from controllers.gait.footstep_file import read_footsteps
from controllers.motion import InfeasibleMotion
from controllers.text_file import MOST, read_lines

READERS = (read_lines, read_rows, read_poses, read_footsteps)


@pytest.mark.parametrize("read", READERS)
def test_a_pipe_a_device_and_a_folder_are_refused_at_once(read, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (pipe, tmp_path, type(pipe)("/dev/zero")):
        with pytest.raises(InfeasibleMotion, match="it is not a regular file"):
            read(path)


@pytest.mark.parametrize("read", READERS)
def test_what_is_too_long_missing_or_no_text_is_refused(read, tmp_path):
    path = tmp_path / "motion.csv"
    with pytest.raises(InfeasibleMotion, match="there is no such file"):
        read(path)
    path.write_bytes(b"x (mm)\n0\n\xff")
    with pytest.raises(InfeasibleMotion, match=r"motion\.csv, line 3: byte 0xFF is not UTF-8 text"):
        read(path)
    with path.open("wb") as stream:
        stream.truncate(MOST + 1)
    with pytest.raises(InfeasibleMotion, match=f"it has more than {MOST} bytes"):
        read(path)


def test_a_file_of_the_greatest_length_is_read_without_its_mark(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_bytes(b"\xef\xbb\xbf" + b"\n" * (MOST - 3))
    assert read_lines(path) == [""] * (MOST - 3)


@pytest.mark.parametrize("read", [read_rows, read_poses, read_footsteps])
def test_a_line_and_a_quotation_without_an_end_are_refused(read, tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text(f"x (mm)\n1,{'9' * 200_000}\n")
    with pytest.raises(InfeasibleMotion, match="line 2: it has more than 10000 characters"):
        read(path)
    path.write_text('x (mm)\n1,"' + "2\n" * 100_000)
    with pytest.raises(InfeasibleMotion) as refused:
        read(path)
    assert len(str(refused.value)) < 1000
