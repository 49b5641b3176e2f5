"""Shipped files with drawn mistakes: each is refused with a sentence, soon and in little memory."""

import random
import signal
from pathlib import Path

import pytest

import rig
from rig.assembly import REGISTRY, check_profile
from rig.config import load_experiment, load_profile
from rig.hal import ConfigurationError

CONFIGS = Path(rig.__file__).parents[1] / "configs"
FILES = sorted([*(CONFIGS / "rigs").glob("*.yaml"), *(CONFIGS / "experiments").glob("*.yaml")])
VALUES = [
    "", "~", "true", "yes", "-1", "0", "1e308", "-1e308", "1e999", ".nan", ".inf", "9" * 400,
    "5e-324", "1e-12", "0x" + "F" * 16, "007", "12:30", "[]", "{}", "[1, 2, 3]", "{a: {b: [c]}}",
    "35 kPa", "5 furlong", "3 m^9/(s", "1e999999999 m", "1e-999999999 m", "&a x", "*a",
    "!!python/object/apply:os.system [touch PWNED]", "'", '"', "|", ">-", "- x", "a: b", "\t",
    "'" + "x" * 5000 + "'", "[" * 3000, "{a: " * 3000, "1e5000 km", "-0.0", '"\\uD800"', "\x1b[2J",
    "/dev/zero", "../../../etc/passwd", "spy:///dev/null?file=PWNED", "socket://x:1", "cylinder",
    "1e300 m/s", "-5 V", "[10 V, 0 V]", "[1e300 Pa, 0]", "16", "1 GHz", "0.1e-9 Hz",
]  # fmt: skip
KEYS = ["<<", "extends", "mechanism", "driver", "eds", "channel", "", "? x", "1", "null", "../x"]
LONGEST = 2.0  # s, of a case
LARGEST = 1 << 20  # kB, beyond what the process held before


def mutate(text, chance):
    """Return a file with a few of the mistakes that people and their enemies make."""
    lines = text.split("\n")
    for _ in range(chance.choice([1, 1, 1, 2, 3, 6])):
        at = chance.randrange(len(lines))
        line = lines[at]
        key, colon, _ = line.partition(":")
        kind = chance.randrange(8)
        if kind == 0:
            lines.pop(at)
        elif kind == 1:
            lines.insert(chance.randrange(len(lines)), line)
        elif kind == 2 and colon and key.strip():
            lines[at] = line.replace(key.strip(), chance.choice(KEYS), 1)
        elif kind in (3, 4) and colon:
            lines[at] = f"{key}: {chance.choice(VALUES)}"
        elif kind == 5:
            lines[at] = " " * chance.randrange(8) + line.lstrip()
        elif kind == 6 and line:
            cut = chance.randrange(len(line))
            lines[at] = line[:cut] + chance.choice(VALUES) + line[cut:]
        else:
            lines[at] = line.replace(chance.choice(["mm", "kPa", "Hz", "N", "s"]), "km", 1)
        lines = lines or [""]
    return "\n".join(lines).encode("utf-8", "surrogatepass")


class TooLong(BaseException):
    """A case took longer than it may."""


def judge(seed, folder):
    """Load one file with mistakes; return what is wrong with how that went, if anything is."""
    chance = random.Random(seed)
    source = chance.choice(FILES)
    path = folder / "mine.yaml"
    path.write_bytes(mutate(source.read_text(), chance))

    def too_long(*_):
        raise TooLong

    signal.signal(signal.SIGPROF, too_long)  # of the processor: others use it, too
    signal.setitimer(signal.ITIMER_PROF, LONGEST)
    try:
        if source.parent.name == "rigs":
            check_profile(load_profile(path, REGISTRY, (), (CONFIGS,)))
        else:
            load_experiment(path, REGISTRY, (), (CONFIGS,))
    except ConfigurationError as error:
        if len(str(error)) > 100_000 or "\x1b" in str(error):
            return f"{seed}: what is said of it is no sentence"
    except TooLong:
        return f"{seed}: more than {LONGEST} s"
    except BaseException as error:
        return f"{seed}: {type(error).__name__}: {error}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
    return None


def memory(figure):
    """Return what /proc says of this process' memory, in kB: VmRSS for now, VmHWM for the most."""
    [line] = [s for s in Path("/proc/self/status").read_text().splitlines() if s.startswith(figure)]
    return int(line.split()[1])


def campaign(folder, count, monkeypatch):
    monkeypatch.chdir(folder)
    load_profile("cylinder", REGISTRY, (), (CONFIGS,))  # what is loaded once takes its time once
    Path("/proc/self/clear_refs").write_text("5")  # forget the most that other tests have held
    before = memory("VmRSS")
    wrong = [found for seed in range(count) if (found := judge(seed, folder)) is not None]
    assert wrong == []
    assert memory("VmHWM") - before < LARGEST
    assert {path.name for path in folder.iterdir()} == {"mine.yaml"}


def test_some_files_with_mistakes(tmp_path, monkeypatch):
    campaign(tmp_path, 150, monkeypatch)


@pytest.mark.slow
def test_thousands_of_files_with_mistakes(tmp_path, monkeypatch):
    campaign(tmp_path, 3000, monkeypatch)


@pytest.mark.slow
@pytest.mark.lengthy
def test_a_hundred_thousand_files_with_mistakes(tmp_path, monkeypatch):
    campaign(tmp_path, 100_000, monkeypatch)


@pytest.mark.parametrize("count", [30_000])
def test_unknown_keys_by_the_thousand_are_refused_soon(count, tmp_path):
    path = tmp_path / "mine.yaml"
    text = (CONFIGS / "rigs" / "cylinder.yaml").read_text()
    path.write_text(text + "".join(f"unknown_{k}: 1\n" for k in range(count)))
    signal.signal(signal.SIGPROF, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_PROF, 2 * LONGEST)
    with pytest.raises(ConfigurationError, match=f"{count} errors") as caught:
        load_profile(path, REGISTRY, (), (CONFIGS,))
    signal.setitimer(signal.ITIMER_PROF, 0.0)
    assert len(str(caught.value)) < 100_000
