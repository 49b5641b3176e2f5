"""An emulated CANopen node of any kind: what its description says of it, and nothing more.

References
----------
CiA 301 V4.2: the services that every node has. CiA 306: what an EDS says of a device.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from drivers.sim.nodes.base import EmulatedNode
from drivers.sim.nodes.object_dictionary import BY_NAME, UNSIGNED8, DataType, Variable

Counts = Callable[[], float]


class ObjectBuild(NamedTuple):
    """One object of the node.

    Attributes
    ----------
    object, sub : int
        Its address.
    type : str
        As in profiles, ``i16``.
    default : float
        Its value after power-on.
    writable : bool
        Whether an SDO may write it.
    mapping : str
        ``r`` if an RPDO may carry it, ``t`` if a TPDO may, ``rt`` or empty.
    counts : callable, optional
        What it reads, in counts; else it keeps its value.
    """

    object: int
    sub: int
    type: str
    default: float = 0
    writable: bool = False
    mapping: str = ""
    counts: Counts | None = None


@dataclass(frozen=True, slots=True)
class NodeBuild:
    """The make of a node.

    Parameters
    ----------
    device_type : int
        Object 0x1000.
    vendor, product, serial : int
        Objects 0x1018:1, :2 and :4.
    objects : tuple of ObjectBuild
        Beside those that every emulated node has.
    receive, transmit : tuple
        The objects that each PDO carries as shipped, as a mapping object holds them.
    """

    device_type: int
    vendor: int
    product: int
    serial: int
    objects: tuple[ObjectBuild, ...]
    receive: tuple[tuple[int, ...], ...]
    transmit: tuple[tuple[int, ...], ...]


class EmulatedDescribed(EmulatedNode):
    """A node that exchanges what it is described to exchange; its outputs move nothing.

    Parameters
    ----------
    name : str
        The device's name in the profile, with the part's behind a dot where it has several.
    node_id : int
        1 … 127.
    build : NodeBuild
        What it is.
    """

    def __init__(self, name: str, node_id: int, build: NodeBuild) -> None:
        super().__init__(
            name,
            node_id,
            device_type=build.device_type,
            vendor=build.vendor,
            product_code=build.product,
            serial=build.serial,
        )
        self._inputs: list[tuple[Variable, Counts]] = []
        present = {(variable.index, variable.sub) for variable in self.dictionary}
        for item in build.objects:
            if (item.object, item.sub) not in present:
                self._add(item)
        for index in {item.object for item in build.objects if item.sub}:
            subs = [item.sub for item in build.objects if item.object == index]
            if 0 not in subs and (index, 0) not in present:
                self.dictionary.add(index, 0, Variable(UNSIGNED8, max(subs), "const"))
        self.add_pdos(build.receive, build.transmit)
        self.power_on()

    def sample_inputs(self, now: float) -> None:
        """Bring the input objects up to date."""
        for variable, counts in self._inputs:
            variable.value = _fitted(counts(), variable.data_type)

    def _add(self, item: ObjectBuild) -> None:
        data_type = BY_NAME[item.type]
        variable = Variable(
            data_type,
            _fitted(item.default, data_type),
            "rw" if item.writable else "ro",
            mapping=item.mapping,
            refresh=self._sample if item.counts is not None else None,
        )
        self.dictionary.add(item.object, item.sub, variable)
        if item.counts is not None:
            self._inputs.append((variable, item.counts))

    def _sample(self) -> None:
        self.sample_inputs(self.now)


def _fitted(value: float, data_type: DataType) -> int | float:
    """Return the nearest value that a type can hold."""
    bounded = min(max(value, data_type.low), data_type.high)
    return bounded if data_type.code == "f" else round(bounded)
