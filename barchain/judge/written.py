"""Judgement of results that were written into a file by a program that can't be run again.

Each number is known to half a unit in its last place. The program's own error is estimated by a second, finer result;
by the requested error of each step that is declared; or, without either, by nothing: the digits are then all that may
explain a difference.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from adapters.engine import AccuracyParameter, AccuracySweep, Coordinates, Declarations, Setting, StatedAnswers
from adapters.trajectory import Observable
from barchain.judge.error_model import ErrorModel
from barchain.judge.residuals import Residuals
from barchain.judge.scales import MACHINE_EPSILON
from barchain.solutions.reference import RICHARDSON

if TYPE_CHECKING:
    from collections.abc import Mapping

    from adapters.trajectory import Array, Trajectory
    from barchain.judge.evidence import Evidence

FULL_DIGITS = 1e-13
"""Largest error of writing, relative to a quantity's scale, of states that a restart of the reference can go on from"""
MOST_CHANGE_SHARE = 1e-2
"""Largest change between two results that counts as their error, relative to a quantity's scale: as much of a radian
ends the comparison of attitudes"""


class Undeclared(Setting):
    """Setting of a program that declares no requested error: no step promises anything."""

    def __str__(self) -> str:
        """In place of a number."""
        return "as written"


@dataclass(frozen=True)
class Declared:
    """What a person declares about the program that wrote a file."""

    order: float | None = None
    """Order of its method of equal steps"""
    rtol: float | None = None
    """Requested error of one step"""
    absolute: bool = False
    """Whether it integrates places from the centre of the central body, which decides its round-off"""
    noise: Mapping[str, float] = field(default_factory=dict)
    """Errors that do not fall with the step, by quantity, in SI units"""

    @property
    def setting(self) -> Setting:
        """Setting of the program."""
        if self.rtol is None:
            return Undeclared(AccuracyParameter.RTOL, MACHINE_EPSILON)
        return Setting(AccuracyParameter.RTOL, self.rtol)

    @property
    def engine(self) -> Declarations:
        """The declarations, as those of an engine."""
        value = self.setting.value
        return Declarations(
            title="a file",
            coordinates=Coordinates.ABSOLUTE if self.absolute else Coordinates.RELATIVE,
            order=self.order,
            sweep=AccuracySweep(AccuracyParameter.RTOL, (value,), value),
            effects=(),
            observables=tuple(sorted(Observable)),
            questions=("noise",),
            answers=StatedAnswers(dict(self.noise)),
        )


class WrittenErrors(ErrorModel):
    """Error model of a program that can't be asked: noise is the error bar that its author states, however wide."""

    noise_is_bounded = False

    @cached_property
    def noise(self) -> dict[str, Array]:
        """Error bars as they are stated, (n,) for each quantity."""
        return self.declared_noise


class MeasuredErrors(WrittenErrors):
    """Error model of a program without a promise: its error is twice the change to its finer result, if there is one.

    Where two runs of a chaotic scene have parted nothing is compared, as ever. Two results that are both garbage differ
    by as much as they are wrong: of each other quantity the change counts up to a share of the solution's size.
    """

    own: Mapping[str, Array] = {}
    """Change to the finer result, (n,) for each quantity, in its unit; set before the first member is asked for"""

    @property
    def by_change_alone(self) -> bool:
        """Whether there is a finer result: no request is known."""
        return bool(self.own)

    @cached_property
    def attitude_rad(self) -> Array:
        """Error of the attitude, (n,) rad."""
        return self.floor_rad + self.estimate("attitude")

    @cached_property
    def bound(self) -> dict[str, Array]:
        """Error of each quantity, (n,), in its unit."""
        return {name: floor + self.estimate(name) for name, floor in self.floor.items()}

    def explained(self, own: dict[str, Array]) -> dict[str, Array]:
        """Largest difference of two correct results, (n,) for each quantity of `own`; the change counts here."""
        return {
            name: self.bound[name] + RICHARDSON * self.solution.error[name][: self.n]
            for name in own.keys() & self.solution.error.keys()
        }

    def estimate(self, quantity: str) -> Array:
        """Richardson's estimate from the change to the finer result, (n,), never falling."""
        if quantity not in self.own:
            return np.zeros(self.n)
        found: Array = RICHARDSON * np.maximum.accumulate(self.own[quantity][: self.n])
        return found if quantity == "attitude" else np.minimum(found, MOST_CHANGE_SHARE * self.scale[quantity])


class WrittenResiduals(Residuals):
    """Residuals of one or two written results; quantities that are not in the file have none."""

    def __init__(
        self, errors: ErrorModel, evidence: Evidence, judged: frozenset[str], *, whole: bool, restarted: bool
    ) -> None:
        """Compare the files.

        Parameters
        ----------
        errors : ErrorModel
        evidence : Evidence
            The finer run is the main one where there is no other.
        judged : frozenset of str
            Quantities that the file has.
        whole : bool
            Whether the file has every part of attitude, rates and track, so that invariants can be computed.
        restarted : bool
            Whether the reference may restart from the file's states.
        """
        self.alone, self.whole, self.restarted = evidence.finer is evidence.main, whole, restarted
        super().__init__(errors, evidence)
        self.difference = {name: d for name, d in self.difference.items() if name in judged}
        self.residual = {name: d for name, d in self.residual.items() if name in judged}
        seen = {} if self.alone else self.finer_residual
        self.finer_residual = {name: d for name, d in seen.items() if name in judged}

    @property
    def com_only(self) -> bool:
        """Not as a particle: the track in the file is that of a chain."""
        return False

    @property
    def restarts(self) -> bool:
        """Whether the file's own states are states to go on from: all there, in every digit, of a declared accuracy."""
        exact = all(np.all(self.errors.written[q] <= FULL_DIGITS * self.scale[q]) for q in ("attitude", "rate"))
        return self.restarted and self.whole and exact and not isinstance(self.setting, Undeclared)

    def drifts(self, run: Trajectory) -> dict[str, Array]:
        """Drifts of conserved quantities, (n,) each; none where a part is not in the file."""
        return super().drifts(run) if self.whole else {}

    def own_error(self) -> dict[str, Array]:
        """Error of the main run, (n,) for each quantity: without a finer one, as large as promised."""
        if not self.alone:
            return super().own_error()
        floor, bound = self.errors.floor, self.errors.bound
        return {name: (bound[name] - floor[name]) / RICHARDSON for name in bound}

    @cached_property
    def extrapolated(self) -> dict[str, tuple[Array, Array]]:
        """Error of the extrapolation and its tolerance; empty without a finer result, or an order."""
        return {} if self.alone else super().extrapolated

    def finer_floor(self, quantity: str) -> Array:
        """Floor of the finer result, (n,): it is written in the same digits."""
        return self.errors.floor[quantity]
