"""Mutants that no test can tell from the file itself, each with the reason."""

from typing import NamedTuple


class Equivalent(NamedTuple):
    """One such mutant.

    Parameters
    ----------
    path : str
        The file.
    line : str
        Its line, without the spaces around it.
    change : str
        The code before and after.
    why : str
        Nothing that can be seen differs.
    """

    path: str
    line: str
    change: str
    why: str


EQUIVALENTS: tuple[Equivalent, ...] = (
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/missing.py",
        "lost.append(lost[-1] + _lost_between(late[-1], instant, self._friction) if late else 0.0)",
        "0.0 -> 1.0",
        "only the difference of two of them counts",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/runs_off.py",
        "way = place - left_at if error > 0.0 else left_at - place",
        "error > 0.0 -> error >= 0.0",
        "what has no error is near",
    ),
    *(
        Equivalent(
            "rig/mechanisms/pneumatic/alarms/balance.py",
            line,
            "off > 0.0 -> off >= 0.0",
            "what has strayed is off by something",
        )
        for line in (
            "against = -pull if off > 0.0 else pull",
            "return self._channels[other if off > 0.0 else one]",
        )
    ),
    *(
        Equivalent(
            "rig/mechanisms/pneumatic/alarms/turns.py",
            f"{word} value {sign} furthest:",
            f"value {sign} furthest -> value {sign}= furthest",
            "an extreme that is put where it is stays there",
        )
        for word, sign in (("if", ">"), ("elif", "<"))
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/tracking.py",
        "way = place - left_at if error > 0.0 else left_at - place",
        "error > 0.0 -> error >= 0.0",
        "an error that is judged is beyond what is permitted, and never 0",
    ),
    *(
        Equivalent(
            "rig/mechanisms/cylinder/mechanism.py",
            "if not math.isfinite(position + p_agonist + p_antagonist):",
            f"{before} -> {before[: before.rindex('+')]}-{before[before.rindex('+') + 1 :]}",
            "what is not finite stays so under either sign; finite readings are far from overflow",
        )
        for before in ("position + p_agonist + p_antagonist", "position + p_agonist")
    ),
    *(
        Equivalent(
            f"rig/mechanisms/{mechanism}/mechanism.py",
            line,
            change,
            "nothing asks for it before the first reading was checked",
        )
        for mechanism, line, changes in (
            (
                "cylinder",
                "self._extensions = (settings.home, settings.home)",
                ("self._extensions = (settings.home, settings.home) -> pass",),
            ),
            ("cylinder", "self._position = self._now = 0.0", ("0.0 -> 1.0",)),
            (
                "joint",
                "self._tensions: Quadruple = (0.0,) * 4",
                ("self._tensions: Quadruple = (0.0,) * 4 -> pass", "0.0 -> 1.0", "4 -> 5"),
            ),
            (
                "joint",
                "self._rods: Quadruple = (0.0,) * 4",
                ("self._rods: Quadruple = (0.0,) * 4 -> pass", "0.0 -> 1.0", "4 -> 5"),
            ),
            ("joint", "self._now = 0.0", ("0.0 -> 1.0",)),
        )
        for change in changes
    ),
    *(
        Equivalent(
            "rig/mechanisms/joint/mechanism.py",
            "estimate = JointEstimate(_ZERO, _ZERO, 0.0, state.rods, (0.0,) * 4)",
            change,
            "the tensions of an estimate are not logged",
        )
        for change in ("0.0 -> 1.0", "4 -> 5")
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/balance.py",
        'weak = " or ".join(',
        "missing < 0.0 -> missing <= 0.0",
        "pairs that lack nothing are not among those found",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/balance.py",
        "weak = self._channels[self._pairs[pair][0 if missing < 0.0 else 1]]",
        "missing < 0.0 -> missing <= 0.0",
        "nothing is said of a pair that lacks nothing",
    ),
    *(
        Equivalent("rig/mechanisms/pneumatic/alarms/balance.py", line, change, why)
        for line, change, why in (
            *(
                (
                    "if t < self._history[-1][0] - over:",
                    change,
                    "it only saves time: who balances forces looks at the last moments alone",
                )
                for change in (
                    "t < self._history[-1][0] - over -> False",
                    "-1 -> 1",
                    "1 -> 2",
                )
            ),
            (
                "return 0.0, missing_pull(late, self._mass, self._friction, sticks=True)",
                "0.0 -> 1.0",
                "of pairs that stick all have the same time",
            ),
            (
                "history, first = self._instants(pair, math.inf), (0.0, 0.0)",
                "0.0 -> 1.0",
                "a pair that lacks nothing is left out, whatever its time; a pull has a test",
            ),
            (
                "first = late[0].t, missing",
                "0 -> 1",
                "each pair began a cycle later then, and only what lies between them counts",
            ),
            (
                "del history[1 - len(late) :]  # all of it, where the one before is long ago",
                "1 -> 2",
                "the stretches that are looked at overlap by two cycles instead of one",
            ),
            (
                "found = [(missing, pair) for when, missing, pair in short if when < began + 0.5 * "
                "LOOK]",
                "when < began + 0.5 * LOOK -> when <= began + 0.5 * LOOK",
                "a run is found to begin a few milliseconds early or late",
            ),
        )
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/scatter.py",
        "if not follows < _ALTERNATES * power:",
        "follows < _ALTERNATES * power -> follows <= _ALTERNATES * power",
        "they are the same where nothing bends, and then nothing scatters either",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/scatter.py",
        "if most < _LEAST:",
        "most < _LEAST -> most <= _LEAST",
        "a deviation that is worked out is never exactly the bound",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/cut_wire.py",
        "_FASTEST = 1e6",
        "1000000.0 -> 2000000.0",
        "either is far beyond any speed that is permitted: the same pressure is found",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/cut_wire.py",
        "while moved >= _NEAR:",
        "moved >= _NEAR -> moved > _NEAR",
        "no step of the search is exactly a hundredth of a pascal",
    ),
    Equivalent(
        "rig/mechanisms/joint/watch.py",
        "if not math.isfinite(sum(rods) + sum(pressures)):",
        "sum(rods) + sum(pressures) -> sum(rods) - sum(pressures)",
        "what is not finite stays so under either sign, and finite readings are far from overflow",
    ),
    Equivalent(
        "rig/mechanisms/joint/watch.py",
        "return any(abs(way) > fast for i, way in enumerate(ways) if i != k)",
        "abs(way) > fast -> abs(way) >= fast",
        "no difference of two readings is three tenths of a bound to the last bit",
    ),
    Equivalent(
        "rig/mechanisms/joint/watch.py",
        "self._cycle += 1",
        "self._cycle += 1 -> self._cycle -= 1",
        "every fourth cycle is every fourth one, counted up or down",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/turns.py",
        "self._furthest = -math.inf if rises else math.inf",
        "rises -> True",
        "an extreme that is infinite ends with the next one",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/tracking.py",
        "self._error = Turns(self._error.distance, rises=error < 0.0)",
        "error < 0.0 -> error <= 0.0",
        "from nought either way leads to the same extremes",
    ),
    *(
        Equivalent(
            "drivers/canopen/node.py",
            "if now > self.heartbeat.good_until:",
            f"now > self.heartbeat.good_until -> {after}",
            "it only saves a call: up to then the watch has nothing to say",
        )
        for after in ("True", "now >= self.heartbeat.good_until")
    ),
    Equivalent(
        "rig/mechanisms/servo/axes.py",
        "if abs(speed) > fastest:",
        "abs(speed) > fastest -> abs(speed) >= fastest",
        "a speed that is the greatest is set to it",
    ),
    Equivalent(
        "rig/mechanisms/servo/axes.py",
        "falls = int(0.5 * (math.sqrt(1.0 + 8.0 * left / step) - 1.0) + 1e-9)",
        "0.5 * (math.sqrt(1.0 + 8.0 * left / step) - 1.0) + 1e-09 -> "
        "0.5 * (math.sqrt(1.0 + 8.0 * left / step) - 1.0) - 1e-09",
        "where the number of falls changes, the speed from either number is the same",
    ),
    Equivalent(
        "rig/mechanisms/joint/alarms/wires.py",
        "both = (k, (k + 2) % 4)",
        "k + 2 -> k - 2",
        "modulo four it is the same",
    ),
    *(
        Equivalent(
            "rig/mechanisms/joint/alarms/wires.py",
            line,
            change,
            "a solved pose has no residual that is exactly a bound",
        )
        for line, change in (
            ("if not off > 0.0:", "off > 0.0 -> off >= 0.0"),
            ("if off < 0.0:", "off < 0.0 -> off <= 0.0"),
            (
                "if residual < _LEAST_RESIDUAL or max(map(abs, unstretched)) < _LEAST_TRAVEL:",
                "residual < _LEAST_RESIDUAL -> residual <= _LEAST_RESIDUAL",
            ),
            (
                "if self._residual_of(rods) < _SWAPPED * residual:  # type: ignore[arg-type]",
                "self._residual_of(rods) < _SWAPPED * residual -> "
                "self._residual_of(rods) <= _SWAPPED * residual",
            ),
            ("if drift < 0.25 * distance:", "drift < 0.25 * distance -> drift <= 0.25 * distance"),
            ("elif drift > distance:", "drift > distance -> drift >= distance"),
            (
                "suspects = [k for k in range(4) if offs[k][0] < _EXPLAINED * residual]",
                "offs[k][0] < _EXPLAINED * residual -> offs[k][0] <= _EXPLAINED * residual",
            ),
            (
                "if abs(residuals[left_out]) < 1e-7:",
                "abs(residuals[left_out]) < 1e-07 -> abs(residuals[left_out]) <= 1e-07",
            ),
        )
    ),
    *(
        Equivalent(
            "rig/mechanisms/joint/alarms/runs.py",
            line,
            change,
            "no way of a whole number of counts is such a decimal of a metre",
        )
        for line, change in (
            (
                "return among[first] if leads and ways[first] > _LEAST_WAY else None",
                "ways[first] > _LEAST_WAY -> ways[first] >= _LEAST_WAY",
            ),
            (
                "return max(step[1]) > _BEGINS * step[0]",
                "max(step[1]) > _BEGINS * step[0] -> max(step[1]) >= _BEGINS * step[0]",
            ),
        )
    ),
    Equivalent(
        "rig/mechanisms/cylinder/watch.py",
        "self._step = self._then = 0.0",
        "0.0 -> 1.0",
        "nobody asks for the first step: a run takes two cycles",
    ),
    Equivalent(
        "rig/mechanisms/cylinder/watch.py",
        "return False",
        "return False -> return None",
        "who asks whether a rod runs takes either for no",
    ),
    Equivalent(
        "rig/mechanisms/cylinder/watch.py",
        'slack = "" if change > 0.0 else "a wire is slack, or "',
        "change > 0.0 -> change >= 0.0",
        "asked beyond a bound only",
    ),
    Equivalent(
        "rig/mechanisms/cylinder/watch.py",
        "for k, sign in enumerate((-1.0, 1.0)):",
        "1.0 -> 2.0",
        "a rod's work and its way both double, and only their ratio counts",
    ),
    *(
        Equivalent(
            "rig/mechanisms/cylinder/watch.py",
            line,
            change,
            "no way of whole counts, and no sum of works, is a bound to the last bit",
        )
        for line, change in (
            (
                "return abs(late[1] - late[0]) > _JUMP * self._limits.speed * self._step",
                "abs(late[1] - late[0]) > _JUMP * self._limits.speed * self._step -> "
                "abs(late[1] - late[0]) >= _JUMP * self._limits.speed * self._step",
            ),
            (
                "if max(ways) < least or min(ways) < _LEAST_RUN * max(ways):",
                "max(ways) < least -> max(ways) <= least",
            ),
            (
                "if max(ways) < least or min(ways) < _LEAST_RUN * max(ways):",
                "min(ways) < _LEAST_RUN * max(ways) -> min(ways) <= _LEAST_RUN * max(ways)",
            ),
            (
                "if abs(before.change) < _AGREED * self._bound:",
                "abs(before.change) < _AGREED * self._bound -> "
                "abs(before.change) <= _AGREED * self._bound",
            ),
            (
                "if work[k] < -self._least_work * way[k] and "
                "work[1 - k] > self._least_work * way[1 - k]:",
                "work[k] < -self._least_work * way[k] -> work[k] <= -self._least_work * way[k]",
            ),
            (
                "if work[k] < -self._least_work * way[k] and "
                "work[1 - k] > self._least_work * way[1 - k]:",
                "work[1 - k] > self._least_work * way[1 - k] -> "
                "work[1 - k] >= self._least_work * way[1 - k]",
            ),
        )
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/pressures.py",
        "if channel.off > 0.0:",
        "channel.off > 0.0 -> channel.off >= 0.0",
        "asked of the channel that is farthest off only",
    ),
    *(
        Equivalent(
            "rig/mechanisms/pneumatic/alarms/answers.py",
            "if -most <= pressure - late <= most:  # most of the time, and cheap",
            change,
            "it only saves the second half, which finds the same",
        )
        for change in (
            "-most <= pressure - late <= most -> False",
            "-most -> most",
            "-most <= pressure - late <= most -> -most < pressure - late <= most",
            "-most <= pressure - late <= most -> -most <= pressure - late < most",
            "pressure - late -> pressure + late",
        )
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/answers.py",
        "return likeness > bounds.slow * power and self.slowness(bounds) > self.most_slow(bounds)",
        "likeness > bounds.slow * power -> likeness >= bounds.slow * power",
        "it only saves the second half, which asks for more",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/frozen.py",
        "if is_long and self.gone(k) > self._moved and monitor.was_lively > _LIVELY:",
        "monitor.was_lively > _LIVELY -> monitor.was_lively >= _LIVELY",
        "a share that approaches 1 by fractions of a period is a half to the last bit never",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/cut_wire.py",
        "if way > stroke:",
        "way > stroke -> way >= stroke",
        "no sum of steps is the stroke to the last bit, and one more step changes nothing",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/jumped.py",
        "self._ways = [0.0] * count",
        "0.0 -> 1.0",
        "the cycle after it begins no jump, whatever went before",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/jumped.py",
        "self._is_stopping, self._unread = False, 0.0",
        "0.0 -> 1.0",
        "the first cycle looks for no jump, and sets it",
    ),
    Equivalent(
        "rig/mechanisms/pneumatic/alarms/jumped.py",
        "self._stayed = [0] * count",
        "0 -> 1",
        "a jump begins its count itself",
    ),
    Equivalent(
        "rig/mechanisms/servo/stuck.py",
        "if asked <= self._least:",
        "asked <= self._least -> asked < self._least",
        "where a joint that followed begins anew matters by a fraction of a bit",
    ),
    Equivalent(
        "rig/mechanisms/servo/stuck.py",
        "gone = here - stood[k] if way > 0.0 else stood[k] - here",
        "way > 0.0 -> way >= 0.0",
        "a way of nothing was passed over before",
    ),
)
