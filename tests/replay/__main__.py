"""Record the corpus anew: ``python tests/replay [NAME …]``, with the reason in the manifest.

A change of a command makes the gate red. Whoever means it renews the recordings that it concerns,
in the same commit, with ``--because "…"``; the manifest keeps the sentence.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from replay.arithmetic import keep
from replay.corpus_files import CORPUS, MANIFEST, SUFFIX, pack
from replay.recording import record
from replay.recordings import RECORDINGS

from rig.hal import RigError


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="default: all of them")
    parser.add_argument("--because", required=True, help="why the commands are others now")
    chosen = parser.parse_args()
    unknown = set(chosen.names) - RECORDINGS.keys()
    if unknown:
        parser.error(f"no recording is called {', '.join(sorted(unknown))}")
    CORPUS.mkdir(parents=True, exist_ok=True)
    keep()
    kept = json.loads(MANIFEST.read_text()) if MANIFEST.exists() else {}
    for name in chosen.names or RECORDINGS:
        recording = RECORDINGS[name]
        with tempfile.TemporaryDirectory() as folder:
            try:
                cycles = pack(record(recording, Path(folder)), CORPUS / f"{name}{SUFFIX}")
            except (AssertionError, RigError) as error:
                sys.stderr.write(f"not recorded: {error}\n")
                continue
        kept[name] = {"shows": recording.reason, "cycles": cycles, "because": chosen.because}
        MANIFEST.write_text(
            json.dumps({k: kept[k] for k in sorted(kept) if k in RECORDINGS}, indent=2) + "\n"
        )
        sys.stdout.write(f"{name}: {cycles} cycles\n")
    for path in CORPUS.glob(f"*{SUFFIX}"):
        if path.name.removesuffix(SUFFIX) not in RECORDINGS:
            path.unlink()


if __name__ == "__main__":
    main()
