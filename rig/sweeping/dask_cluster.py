"""Points on a Dask cluster: its scheduler hands them to workers, wherever those are.

Who reaches a scheduler can run any code on its workers. So one that others reach needs TLS.
"""

import contextlib
import itertools
import json
import logging
import queue
import re
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rig.hal import ConfigurationError
from rig.hal.errors import ConnectionFailed
from rig.hal.files import read_regular
from rig.installation import installing
from rig.sweeping.dask_worker import pack, run_here
from rig.sweeping.engine import PointReport, WorkerSetup
from rig.sweeping.errors import SweepStopped
from rig.sweeping.point import PointJob

if TYPE_CHECKING:
    from distributed import Client, Future

_CONNECT: Final = 10.0
"""How long a scheduler may take to answer, s."""
_NO_WORKERS: Final = 60.0
"""So long a cluster may be without workers, s."""
_GONE: Final = 5.0
"""So long a scheduler may be silent, s."""
_AHEAD: Final = 2
"""Points for each thread of the cluster, so that none waits for the scheduler."""
_LOOPBACK: Final = re.compile(r"(localhost|127\.[0-9.]+|\[?::1\]?)(:[0-9]+)?")


_MOST: Final = 1 << 20
"""Bytes of a scheduler's file."""


def address_of(given: str) -> str:
    """Return the address of a scheduler, given itself or as the scheduler's file.

    Raises
    ------
    ConfigurationError
        It is neither, or others reach the scheduler and there is no TLS.
    """
    address = given
    if "://" not in given:
        try:
            address = str(json.loads(read_regular(Path(given), _MOST).decode())["address"])
        except (ConfigurationError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise ConfigurationError(
                f"--dask {given}: neither an address such as tcp://127.0.0.1:8786 nor the file of "
                f"a scheduler ({error})"
            ) from error
    protocol, _, place = address.partition("://")
    if protocol not in ("tcp", "tls"):
        raise ConfigurationError(f"--dask {given}: expected tcp://HOST:PORT or tls://HOST:PORT")
    if protocol == "tcp" and not _LOOPBACK.fullmatch(place):
        raise ConfigurationError(
            f"--dask {given}: whoever reaches a scheduler runs code on its workers, so one that is "
            "not on this host's loopback needs TLS: tls://HOST:PORT, with the certificates in "
            "Dask's configuration (distributed.comm.tls)"
        )
    return address


class DaskCluster:
    """The workers of a Dask cluster.

    Parameters
    ----------
    given : str
        The scheduler's address, or its file.
    setup : WorkerSetup
        What its workers need.
    configs : Path
        The configurations of the points.

    Raises
    ------
    ConfigurationError
        There is no Dask here, or the address is none.
    ConnectionFailed
        No scheduler answers there, or it has no workers.
    SweepStopped
        It is of another version.
    """

    def __init__(self, given: str, setup: WorkerSetup, configs: Path) -> None:
        self._address = address_of(given)
        self._setup = setup._replace(log=None)
        self._client = _connect(self._address)
        try:
            _check_versions(self._client, self._address)
            self.slots = _AHEAD * _wait_for_threads(self._client, self._address)
            # A task and not scattered data: were it lost with its worker, it would be made again.
            self._configs = self._client.submit(bytes, pack(configs), pure=False)
        except BaseException:
            self.close()
            raise
        self._numbers = itertools.count()
        self._done: queue.SimpleQueue[Future] = queue.SimpleQueue()
        self._names: dict[str, tuple[str, Future]] = {}
        self._silent_since: float | None = None

    def submit(self, job: PointJob) -> None:
        """Hand a point to the scheduler."""
        key = f"rig-{job.name[:8]}-{next(self._numbers)}"
        future = self._client.submit(
            run_here, job, self._setup, self._configs, key=key, pure=False, retries=0
        )
        self._names[key] = job.name, future
        future.add_done_callback(self._done.put)

    def wait(self, timeout: float) -> list[PointReport]:
        """Return what the cluster says.

        Raises
        ------
        SweepStopped
            The scheduler has gone.
        """
        reports = []
        with contextlib.suppress(queue.Empty):
            future = self._done.get(timeout=timeout)
            while True:
                name, _ = self._names.pop(future.key)
                reports.append(self._report(name, future))
                future = self._done.get_nowait()
        self._check_alive()
        return reports

    def close(self) -> None:
        """Let go of the cluster; what runs there is cancelled."""
        with contextlib.suppress(Exception):  # it may be what failed
            self._client.close(timeout=2.0)

    def _report(self, name: str, future: "Future") -> PointReport:
        if future.status in ("cancelled", "lost"):
            raise self._gone()
        try:
            if future.status == "finished":
                report: PointReport = future.result(timeout=_GONE)
                return report
            error = future.exception(timeout=_GONE)
        except (OSError, TimeoutError) as lost:  # it went while it was asked for what it has
            raise self._gone() from lost
        if type(error).__name__ == "KilledWorker":
            return PointReport(name, died=True)
        return PointReport(name, trouble=f"a worker of {self._address} cannot run points: {error}")

    def _check_alive(self) -> None:
        if self._client.status == "running":
            self._silent_since = None
            return
        now = time.monotonic()
        self._silent_since = self._silent_since or now
        if now - self._silent_since > _GONE or self._client.status == "closed":
            raise self._gone()

    def _gone(self) -> SweepStopped:
        return SweepStopped(
            self._address, "the Dask scheduler has gone; what is finished is kept, and the same "
            "command goes on from there"
        )  # fmt: skip


def _connect(address: str) -> "Client":
    try:
        from distributed import Client
    except ImportError as error:
        raise ConfigurationError(
            f"--dask takes Dask distributed: {installing('distributed')}"
        ) from error
    # Lost connections are said in a sentence of our own.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        return Client(address, timeout=_CONNECT, set_as_default=False)
    except (OSError, TimeoutError, ValueError, RuntimeError) as error:
        raise ConnectionFailed(
            address, f"no Dask scheduler answers ({type(error).__name__}); begin one with: "
            "dask scheduler --host 127.0.0.1"
        ) from error  # fmt: skip


def _check_versions(client: "Client", address: str) -> None:
    import distributed

    found = client.get_versions()
    others = {"scheduler": found["scheduler"], **found["workers"]}
    for who, told in others.items():
        version = ((told or {}).get("packages") or {}).get("distributed")
        if version != distributed.__version__:
            raise SweepStopped(
                address, f"its {who} is of distributed {version}, this program of "
                f"{distributed.__version__}: install the same"
            )  # fmt: skip


def _wait_for_threads(client: "Client", address: str) -> int:
    end = time.monotonic() + _NO_WORKERS
    while not (threads := int(sum(client.nthreads().values()))):
        if time.monotonic() > end:
            raise ConnectionFailed(address, "its cluster has no workers")
        time.sleep(0.2)
    return threads
