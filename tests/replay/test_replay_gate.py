"""No command of any law has changed since the corpus was recorded.

Bit for bit, where numbers are rounded as they were; up to rounding on another processor or with
other libraries (`arithmetic`).
"""

import json

import pytest
from replay.arithmetic import is_as_recorded, nearly
from replay.corpus_files import CORPUS, MANIFEST, SUFFIX, unpack
from replay.recordings import RECORDINGS

from rig.replaying.recorded import open_recorded
from rig.replaying.verify import same_bits, verify

KEPT = json.loads(MANIFEST.read_text())
AGREE = same_bits if is_as_recorded() else nearly


def test_the_corpus_is_the_list_of_recordings_and_each_says_why_it_is_as_it_is():
    assert len(RECORDINGS) >= 60
    assert sorted(KEPT) == sorted(RECORDINGS)
    assert sorted(path.name for path in CORPUS.glob(f"*{SUFFIX}")) == sorted(
        name + SUFFIX for name in KEPT
    )
    assert all(entry["because"].strip() and entry["cycles"] > 100 for entry in KEPT.values())


@pytest.mark.parametrize("name", sorted(KEPT))
def test_every_number_is_the_one_that_was_recorded(name, tmp_path):
    found = verify(open_recorded(unpack(CORPUS / f"{name}{SUFFIX}", tmp_path / name)), agree=AGREE)
    told = (
        f"{found.difference or found.stopped}\n\nIf that is meant, renew the recording and say "
        f"why: python tests/replay {name} --because '…'"
    )
    assert found.same, told
    assert found.cycles + found.unknown == KEPT[name]["cycles"]
