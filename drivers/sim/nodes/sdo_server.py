"""The SDO server of an emulated node: expedited and segmented transfers.

References
----------
CiA 301 V4.2, section 7.2.4 (service data object). Block transfer is optional there and
answered with "command specifier not valid" here.
"""

from collections.abc import Callable
from math import inf

from drivers.sim.nodes.object_dictionary import Abort, ObjectDictionary, SdoAbortError

# Client command specifiers (bits 7..5 of the first byte).
_DOWNLOAD_SEGMENT, _INITIATE_DOWNLOAD, _INITIATE_UPLOAD, _UPLOAD_SEGMENT, _ABORT = range(5)
_TIMEOUT = 1.0  # a segmented transfer that pauses for longer is aborted, s


class SdoServer:
    """Answer the requests of one client.

    Parameters
    ----------
    dictionary : ObjectDictionary
        What is read and written.
    send : callable
        Takes the 8 bytes of an answer.
    """

    def __init__(self, dictionary: ObjectDictionary, send: Callable[[bytes], None]) -> None:
        self._dictionary = dictionary
        self._send = send
        self.refused: dict[tuple[int, int], int] = {}
        self.due = inf
        self.reset()

    def reset(self) -> None:
        """Forget a transfer under way."""
        self._address = (0, 0)
        self._upload: bytes | None = None
        self._download: bytearray | None = None
        self._expected: int | None = None
        self._toggle = 0
        self.due = inf

    def receive(self, data: bytes, now: float) -> None:
        """Serve one request; anything but 8 bytes is no SDO and is ignored."""
        if len(data) != 8:
            return
        specifier = data[0] >> 5
        try:
            if specifier == _ABORT:
                self.reset()
                return
            if specifier in (_INITIATE_DOWNLOAD, _INITIATE_UPLOAD):
                self.reset()
                self._address = (int.from_bytes(data[1:3], "little"), data[3])
                if self._address in self.refused:
                    raise SdoAbortError(self.refused[self._address])
                initiate = (
                    self._initiate_upload
                    if specifier == _INITIATE_UPLOAD
                    else self._initiate_download
                )
                answer = initiate(data)
            elif specifier == _UPLOAD_SEGMENT and self._upload is not None:
                answer = self._upload_segment(data)
            elif specifier == _DOWNLOAD_SEGMENT and self._download is not None:
                answer = self._download_segment(data)
            else:
                raise SdoAbortError(Abort.COMMAND)
        except SdoAbortError as abort:
            self._abort(abort.code)
            return
        under_way = self._upload is not None or self._download is not None
        self.due = now + _TIMEOUT if under_way else inf
        self._send(answer)

    def tick(self, now: float) -> None:
        """Abort a transfer whose client has gone."""
        if now >= self.due:
            self._abort(Abort.TIMEOUT)

    def _abort(self, code: int) -> None:
        index, sub = self._address
        self.reset()
        self._send(_header(0x80, index, sub) + int(code).to_bytes(4, "little"))

    def _initiate_upload(self, _: bytes) -> bytes:
        index, sub = self._address
        data = self._dictionary.read(index, sub)
        if 1 <= len(data) <= 4:
            # Expedited with size indicated: 0100 nn11b.
            return _header(0x43 | (4 - len(data)) << 2, index, sub) + data.ljust(4, b"\0")
        self._upload = data
        return _header(0x41, index, sub) + len(data).to_bytes(4, "little")

    def _upload_segment(self, request: bytes) -> bytes:
        self._check_toggle(request[0])
        assert self._upload is not None
        segment, rest = self._upload[:7], self._upload[7:]
        last = not rest
        command = self._toggle << 4 | (7 - len(segment)) << 1 | last
        self._toggle ^= 1
        self._upload = None if last else rest
        return bytes((command,)) + segment.ljust(7, b"\0")

    def _initiate_download(self, request: bytes) -> bytes:
        index, sub = self._address
        variable = self._dictionary.find(index, sub)
        expedited, sized = request[0] & 0x02, request[0] & 0x01
        if expedited:
            # Without an indicated size the type says how much of the four bytes counts.
            size = 4 - (request[0] >> 2 & 0x03) if sized else variable.data_type.size
            self._dictionary.write(index, sub, bytes(request[4 : 4 + size]))
        else:
            if variable.access != "rw":
                raise SdoAbortError(Abort.READ_ONLY)
            self._expected = int.from_bytes(request[4:8], "little") if sized else None
            if sized and variable.data_type.size not in (0, self._expected):
                raise SdoAbortError(Abort.LENGTH)
            self._download = bytearray()
        return _header(0x60, index, sub) + bytes(4)

    def _download_segment(self, request: bytes) -> bytes:
        self._check_toggle(request[0])
        assert self._download is not None
        self._download += request[1 : 8 - (request[0] >> 1 & 0x07)]
        answer = bytes((0x20 | self._toggle << 4,)) + bytes(7)
        self._toggle ^= 1
        if request[0] & 0x01:
            data = bytes(self._download)
            if self._expected is not None and len(data) != self._expected:
                raise SdoAbortError(Abort.LENGTH)
            self._dictionary.write(*self._address, data)
            self._download = None
        return answer

    def _check_toggle(self, command: int) -> None:
        if command >> 4 & 1 != self._toggle:
            raise SdoAbortError(Abort.TOGGLE)


def _header(command: int, index: int, sub: int) -> bytes:
    return bytes((command, index & 0xFF, index >> 8, sub))
