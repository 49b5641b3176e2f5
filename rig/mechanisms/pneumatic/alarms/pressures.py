"""Tell which regulator is stuck, slow or off, and how, or that the supply is gone."""

from collections.abc import Iterable, Sequence
from contextlib import suppress

from rig.hal import SafetyError
from rig.hal.devices import HARMLESS, VENTED
from rig.mechanisms.pneumatic.alarms.answers import LEAST_LAG, ChannelAnswers
from rig.mechanisms.pneumatic.alarms.bounds import PressureBounds
from rig.mechanisms.pneumatic.alarms.dead_time import DeadTimeLine
from rig.mechanisms.pneumatic.alarms.frozen import FrozenMonitors
from rig.mechanisms.pneumatic.alarms.jumped import JumpedMonitors
from rig.mechanisms.pneumatic.alarms.swinging import PressureSwings
from rig.mechanisms.pneumatic.alarms.ways import PressureWays
from rig.mechanisms.pneumatic.settings import RegulatorModel

_ALIKE = 0.5
"""A channel that is off by this share of the permitted deviation is off like the worst one."""
_MOVED = 0.25
"""A pressure that has changed by this share of the deviation since it was well is not held."""
_JUMPED = 0.7
"""A monitor jumps by this share of what it is off in one cycle; air takes a few."""
_MEAN = 4.0
"""Time constants of the regulator over which the mean deviation is taken, and for which it must be
slow: at the beginning of a step dead time looks the same."""
_LEAST_MEAN = 0.05
"""It is taken over no less, s: a rod that slips, and setpoints that turn round at once, push a
pressure about for so long, however quick what feeds the chamber is."""
_USUAL = 5.0
"""Time over which a deviation becomes the usual one, s: that of an uncalibrated regulator is. A
ramp while all chambers fill takes as long, and what a slow one lags by in it is not usual."""
_SLOW = 1.0
"""Time over which a deviation is compared with that of a slow regulator, s."""
_MOVES = 0.5
"""A pressure that goes so far along with a healthy one follows its setpoints …"""
_STAYS = 0.25
"""… and one that goes less than this share of its way is held."""
_FROZEN = 2.0
"""A monitor may not say the very same while a pressure moves by so many times the hysteresis."""
_EMPTY = 4.0
"""Of the hysteresis: up to so much an empty chamber's monitor may say the very same."""
_LEAP = 2.0
"""Of the offset at rest: by so much a monitor that jumps within a cycle is off."""
_TO_AND_FRO = 3.0
"""Of what a late regulator may be off: a setpoint that jumps by more explains a pressure beside."""
_HOP = HARMLESS - VENTED
"""A monitor that jumps by less, Pa, hides no more than a chamber may hold."""


class PressureOff(SafetyError):
    """A pressure is not where a healthy regulator would have brought it."""


class PressureWatch:
    """Compares the chambers' pressures with what healthy regulators would make of the setpoints.

    These answer after the dead time that the profile says, or sooner: what it says is the worst
    channel's, or a guess.

    What it cannot see: a regulator that is stuck or slow while its setpoint stands still, for it
    does what it should; a leak that the regulator makes up for; and a monitor that was off
    before the run by less than the permitted deviation, which is the calibration's to find.

    Parameters
    ----------
    bounds : PressureBounds
        How far and how long.
    response : RegulatorModel
        Of a healthy regulator: second order after a dead time.
    channels : sequence of str
        For messages.
    device : str
        The regulators' name, for messages.
    part : str
        What feeds a chamber, for messages: a valve, where an inner loop makes a regulator of it.
    """

    def __init__(
        self,
        bounds: PressureBounds,
        response: RegulatorModel,
        channels: Sequence[str],
        device: str,
        part: str = "regulator",
    ) -> None:
        self._bounds = bounds
        self._part = part
        self._stiffness = response.bandwidth**2
        self._drag = 2.0 * response.damping * response.bandwidth
        self._mean_time = max(_MEAN / response.bandwidth, _LEAST_MEAN)
        self._names = tuple(channels)
        self._device = device
        self._channels: tuple[ChannelAnswers, ...] = ()
        self._began: float
        self._then: float
        self._pressures: Sequence[float]
        self._setpoints: Sequence[float] = ()
        self._line = DeadTimeLine(response.dead_time)
        self._ways = PressureWays(self._mean_time)
        self._swings = PressureSwings(channels, part)
        loop = bounds.loop
        self._frozen = FrozenMonitors(bounds.time, _FROZEN * loop, _EMPTY * loop)
        self._jumped = JumpedMonitors(min(_HOP, _LEAP * bounds.offset))
        self._is_stopping = False
        self.jumps = [0.0] * len(self._names)
        """By how much each monitor is off since air came on, as its jumps have it, Pa."""

    @property
    def device(self) -> str:
        """The regulators' name."""
        return self._device

    @property
    def names(self) -> tuple[str, ...]:
        """The chambers'."""
        return self._names

    def follow_stop(
        self, pressures: Sequence[float], setpoints: Sequence[float], now: float
    ) -> None:
        """Go on in a cycle of the safe stop: what jumps is noted, and nothing is raised any more.

        Parameters
        ----------
        pressures, setpoints : sequence of float
            What the monitors say, and what the safe state asks for, Pa gauge.
        now : float
            s.
        """
        self._jumped.follow_stop()
        self._is_stopping = True
        self.send(setpoints)
        with suppress(SafetyError):
            self.check(pressures, now)

    def send(self, setpoints: Sequence[float]) -> None:
        """Take the setpoints of this cycle, Pa gauge."""
        self._setpoints = setpoints

    def check(self, pressures: Sequence[float], now: float) -> None:
        """Take this cycle's readings (Pa gauge), and raise if one has been off for too long.

        Raises
        ------
        SafetyError
            It names the channel and the likeliest cause.
        """
        self._pressures = pressures
        setpoints = self._setpoints
        if not self._channels or not setpoints or now <= self._then:
            self._begin(now)
            return
        acting = self._line.pass_on(setpoints, now)
        step, self._then = now - self._then, now
        bounds = self._bounds
        deviation, most, stray = bounds.deviation, bounds.offset, bounds.stray
        alike = _ALIKE * min(deviation, stray)
        pull, drag = step * self._stiffness, step * self._drag
        mean = step / (self._mean_time + step)
        usual = step / (min(now - self._began + self._mean_time, _USUAL) + step)
        share = step / (_SLOW + step)
        long_off = strange = False
        for k, channel in enumerate(self._channels):
            pressure, before = pressures[k], channel.off
            channel.answer(acting[k], setpoints[k], step, pull, drag)
            channel.take(pressure)
            off, lag = channel.off, channel.slow - channel.expected
            if -alike <= off <= alike:
                channel.held = pressure
            if -deviation <= off <= deviation:
                channel.well_at = now
            if not channel.strays(pressure, setpoints[k], stray):
                channel.near_at = now
            if now - channel.well_at > bounds.time or now - channel.near_at > bounds.unasked:
                long_off = True
            jump = max(channel.jump, abs(off - before))
            channel.jump = 0.0 if -most < off - channel.usual < most else jump
            channel.mean += mean * (off - channel.mean)
            channel.learn(pressure, lag, usual, share, bounds)
            channel.lag_mean += mean * (abs(lag) - channel.lag_mean)
            if not channel.compare(lag, share, bounds):
                channel.quick_at = now
            if now - channel.quick_at > self._mean_time or not (
                abs(channel.mean - channel.usual) <= channel.most_mean(bounds)
            ):
                strange = True
        healthy = [channel.expected for channel in self._channels]
        self._ways.note(now, pressures, healthy)
        self._swings.note(now, setpoints, pressures)
        frozen = self._frozen.find(pressures, healthy, now)
        self._check_jumps(pressures, healthy, step)
        if long_off:
            self._raise_off(now)
        if frozen is not None:
            self._raise_frozen(frozen, now)
        if strange:
            self._raise_strange()

    def _begin(self, now: float) -> None:
        self._channels = tuple([ChannelAnswers(pressure, now) for pressure in self._pressures])
        self._began = self._then = now
        self._line.clear()
        self._ways.clear()
        self._swings.clear()
        self._frozen.begin(self._pressures, now)

    def _raise_off(self, now: float) -> None:
        bounds, channels = self._bounds, self._channels

        def overdue(k: int) -> tuple[float, bool]:
            off = now - channels[k].well_at - bounds.time
            strayed = now - channels[k].near_at - bounds.unasked
            return max(off, strayed), strayed > off

        k = max(range(len(channels)), key=overdue)
        channel, (_, strayed) = channels[k], overdue(k)
        since, most, time = (
            (channel.near_at, bounds.stray, bounds.unasked)
            if strayed
            else (channel.well_at, bounds.deviation, bounds.time)
        )
        late = ", even of a late one," if strayed else ""
        swings = self._swings.explain()
        if strayed and not swings:
            swings = self._swings.explain_jump(k, _TO_AND_FRO * most)
        raise PressureOff(
            f"{self._device}: {self._explain()}{swings} [{self._names[k]}: "
            f"{self._pressures[k] * 1e-3:.0f} kPa, setpoint "
            f"{self._setpoints[k] * 1e-3:.0f} kPa, {channel.off * 1e-3:+.0f} kPa off a "
            f"healthy {self._part}{late} for {now - since:.3f} s, at most "
            f"{most * 1e-3:.0f} kPa for {time:.3g} s]"
        )

    def _check_jumps(self, pressures: Sequence[float], healthy: list[float], step: float) -> None:
        off: Sequence[float] = pressures
        if not self._is_stopping:
            off = [pressure - should for pressure, should in zip(pressures, healthy, strict=True)]
        found = self._jumped.find(off, pressures, step)
        if found is None:
            return
        k, jump, is_away = found
        self.jumps[k] += jump
        if not is_away or abs(jump) <= _LEAP * self._bounds.offset:
            return
        raise PressureOff(
            f"{self._device}: the monitor of {self._names[k]} has jumped, and its air cannot "
            f"[{self._names[k]}: by {jump * 1e-3:+.0f} kPa from one cycle to the next, at most "
            f"{_LEAP * self._bounds.offset * 1e-3:.3g} kPa]"
        )

    def _raise_frozen(self, k: int, now: float) -> None:
        raise PressureOff(
            f"{self._device}: the monitor of {self._names[k]} is frozen, or its {self._part} is "
            f"stuck [{self._names[k]}: exactly {self._pressures[k] * 1e-3:.1f} kPa for "
            f"{now - self._frozen.since(k):.3f} s, at most {self._bounds.time:.3g} s while a "
            f"healthy {self._part} goes by {self._frozen.gone(k) * 1e-3:.1f} kPa]"
        )

    def _raise_strange(self) -> None:
        bounds, channels = self._bounds, self._channels
        k = max(range(len(channels)), key=lambda k: channels[k].strangeness(bounds))
        name, channel = self._names[k], channels[k]
        moved = (channel.mean - channel.usual) * 1e-3
        raise PressureOff(
            f"{self._device}: {self._explain_strange(k)}{self._swings.explain()} [{name}: "
            f"{self._pressures[k] * 1e-3:.0f} kPa, setpoint {self._setpoints[k] * 1e-3:.0f} kPa; "
            f"the mean is {moved:+.1f} kPa off what is usual, at most "
            f"{channel.most_mean(bounds) * 1e-3:.3g} kPa; as far off as "
            f"{channel.slowness(bounds):.2f} of a {self._part} of half the bandwidth, at most "
            f"{channel.most_slow(bounds):.2f}]"
        )

    def _explain_strange(self, k: int) -> str:
        name, channel, channels = self._names[k], self._channels[k], self._channels
        bound, part = self._bounds.offset, self._part
        if channel.is_slow(self._bounds):
            return f"the {part} of {name} is slow"
        low = [i for i, other in enumerate(channels) if other.mean - other.usual < -_ALIKE * bound]
        if len(low) > 1 and k in low:
            short = _fall_short(self._names[i] for i in low)
            if all(channels[i].usual > _ALIKE * bound for i in low):
                return f"at rest no {part} goes as low as it was asked to, or {short}"
            return short
        least = LEAST_LAG * self._bounds.loop
        if self._ways.share_gone(k, least) < _STAYS:
            return f"{self._explain()}, or it is slow"
        comes_late = self._ways.beyond(k) <= self._bounds.deviation
        if comes_late and channel.slowness(self._bounds) > channel.most_slow(self._bounds):
            return f"the {part} of {name} is slow, or answers late"
        if abs(channel.off) > self._bounds.deviation:
            return f"{self._explain()}, or it is slow"
        follows = self._ways.follows(k, least) > _MOVES
        if follows and channel.mean - channel.usual > _ALIKE * bound:
            return f"the {part} of {name} fills faster than it empties, or its monitor is off"
        if abs(channel.off) > _ALIKE * self._bounds.deviation:
            return f"{self._explain()}, or it is slow"
        # A spool that stays just off its middle, or a signal that rests while its setpoint moves
        # on, lets a pressure creep away.
        slow = ", slow" if channel.may_be_slow(self._bounds) else ""
        found = f"the {part} of {name} is stuck{slow} or off, or its monitor is off"
        if channel.mean >= channel.usual:
            return found
        # What is not filled at the moment does not fall short yet.
        return f"{found}, or its chamber leaks, or the supply pressure is lost"

    def suspicion(self) -> str | None:
        """Return what looks wrong now, before it has lasted; None if nothing does."""
        worst = max((abs(channel.off) for channel in self._channels), default=0.0)
        if worst <= _ALIKE * self._bounds.deviation:
            return None
        k = max(range(len(self._channels)), key=lambda k: abs(self._channels[k].off))
        return (
            f"{self._device}: {self._explain()}{self._swings.explain()} [{self._names[k]}: "
            f"{self._channels[k].off * 1e-3:+.0f} kPa off a healthy {self._part}, at most "
            f"{self._bounds.deviation * 1e-3:.0f} kPa]"
        )

    def _explain(self) -> str:
        channels, names = self._channels, self._names
        alike = _ALIKE * self._bounds.deviation
        low = [k for k, channel in enumerate(channels) if channel.off < -alike]
        worst = max(range(len(channels)), key=lambda k: abs(channels[k].off))
        channel, name, part = channels[worst], names[worst], self._part
        if len(low) > 1 and worst in low:
            return _fall_short(names[k] for k in low)
        if channel.is_slow(self._bounds):
            return f"the {part} of {name} is slow"
        jumped = channel.jump > _JUMPED * abs(channel.off)
        monitor = f", or the monitor of {name} has jumped" if jumped else ""
        here = self._pressures[worst]
        # Others with more pressure have it from the supply.
        alone = all(pressure <= here + alike for pressure in self._pressures)
        supply = ", or the supply pressure is lost" if alone else ""
        change = here - channel.held
        moved = _MOVED * min(self._bounds.deviation, 2.0 * self._bounds.stray)
        if channel.off > 0.0:
            if change > moved:
                return f"the {part} of {name} is stuck open: its pressure rises{monitor}"
            return f"the {part} of {name} is stuck closed: its pressure stays{monitor}"
        if change < -moved:
            return (
                f"the {part} of {name} is stuck venting, or its tube is off: "
                f"its pressure falls{supply}{monitor}"
            )
        return (
            f"the {part} of {name} is stuck closed, or its chamber leaks: "
            f"its pressure stays{monitor}"
        )


def _fall_short(names: Iterable[str]) -> str:
    """Return why chambers have less than they should: what all of them lack, or lag by."""
    return f"the supply pressure is lost: {', '.join(names)} fall short, or all are slow"
