"""The process that grabs and detects.

It is a process and not a thread because image processing beside the loop, under one
interpreter lock, would cost the loop its deadlines.
"""

import json
import os
import pickle
import socket
import threading
from pathlib import Path
from typing import Final

from drivers.marker_camera.link import Event, Failure, Ready
from drivers.marker_camera.settings import MarkerCameraSettings
from drivers.marker_camera.sighting import Sighting, decode_sighting, encode_sighting
from rig.hal import MonotonicClock

_READY: Final = b"R"
_SIGHTING: Final = b"S"
_FAILURE: Final = b"F"

_LARGEST: Final = 65536
"""Bytes of a packet at most."""

_GRACE: Final = 1.0
"""How long a source may take to let go once the driver has, s."""


def encode_event(event: Event) -> bytes:
    """Return an event as one packet."""
    if isinstance(event, Sighting):
        return _SIGHTING + encode_sighting(event)
    return (_READY if isinstance(event, Ready) else _FAILURE) + json.dumps(event).encode()


def decode_event(packet: bytes) -> Event:
    """Return the event of `encode_event`.

    Raises
    ------
    ValueError
        The packet is not one.
    """
    kind, body = packet[:1], packet[1:]
    if kind == _SIGHTING:
        return decode_sighting(body)
    if kind == _READY:
        return Ready(*json.loads(body))
    if kind == _FAILURE:
        return Failure(*json.loads(body))
    raise ValueError(f"No event starts with {kind!r}.")


def main(descriptor: int) -> None:
    """Run as the process behind an inherited socket.

    Its first packet is the settings and the file for pictures, if there is one, pickled.
    """
    with socket.socket(fileno=descriptor) as driver:
        settings, picture = pickle.loads(driver.recv(_LARGEST))
        assert isinstance(settings, MarkerCameraSettings)
        run_worker(driver, settings, picture)


def run_worker(
    driver: socket.socket, settings: MarkerCameraSettings, picture: Path | None = None
) -> None:
    """Grab, detect and send until the source fails or the driver lets go.

    Parameters
    ----------
    driver : socket
        Packets to the driver; its end closes when the driver or its whole process dies.
    settings : MarkerCameraSettings
        All of the camera.
    picture : Path, optional
        Where pictures are put while somebody looks on.
    """
    _become_ordinary()
    stop = threading.Event()
    threading.Thread(target=_watch_driver, args=(driver, stop), daemon=True).start()
    try:
        _stream(driver, settings, stop, picture)
    except (BrokenPipeError, ConnectionResetError):
        pass  # the driver is gone, and with it everybody who could be told
    except Exception as error:
        what = f"its grabbing process failed: {type(error).__name__}: {error}"
        driver.send(encode_event(Failure(what)))
        raise


def _stream(
    driver: socket.socket,
    settings: MarkerCameraSettings,
    stop: threading.Event,
    picture: Path | None,
) -> None:
    import cv2

    from drivers.marker_camera.detector import MarkerDetector
    from drivers.marker_camera.image_source import SourceFailure
    from drivers.marker_camera.shown import ShownFrames
    from drivers.marker_camera.sources import open_source

    cv2.setNumThreads(1)  # a second core for half a millisecond per frame helps nobody
    source = open_source(settings, MonotonicClock())
    try:
        source.open()
        detector, shown = MarkerDetector(settings), ShownFrames(picture)
        driver.send(encode_event(Ready(source.serial)))
        while not stop.is_set():
            frame = source.read()
            sighting = detector.detect(*frame)
            driver.send(encode_event(sighting))
            shown.offer(frame.image, sighting, detector.places)
    except SourceFailure as failure:
        told = Failure(failure.what, failure.object, failure.value, failure.bound)
        driver.send(encode_event(told))
    finally:
        source.close()


def _watch_driver(driver: socket.socket, stop: threading.Event) -> None:
    """End this process when the driver's end of the socket closes, whatever it was doing."""
    try:
        while driver.recv(1):
            pass
    except OSError:
        pass
    stop.set()
    threading.Event().wait(_GRACE)
    os._exit(0)


def _become_ordinary() -> None:
    """Give back the priority and the core that the loop's process has and its child inherits."""
    try:
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        os.sched_setaffinity(0, range(os.cpu_count() or 1))
    except (AttributeError, OSError):
        pass  # not Linux, or confined to some cores: nothing was inherited that could be undone
