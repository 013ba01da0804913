"""Periodic tables: one period of a measured or computed curve, as a symbolic function of its phase and its values.

Part of the language, beside ``Param`` and ``State``: a law that reads a curve (a mesh stiffness over one base pitch, a gas
torque over one cycle) writes ``PeriodicTable(phase, v_0, ..., v_{n-1})``, and the values may be numbers or parameters.
``lowering`` turns both functions of this file into expressions without branches.

With s = n·phase and the hat function h(s) = max(0, 1 - |s|), repeated with period n, the table is the linear spline
v(phase) = Σ_k v_k h(s - k) (de Boor, A Practical Guide to Splines, chapter III). Its slope jumps at the samples; there the mean
of both sides is taken, which is also what CasADi's derivative of the lowered table gives.
"""

from __future__ import annotations

import sympy
from mpmath.libmp import prec_to_dps
from sympy.core.function import ArgumentIndexError

from modelgen.errors import ModelError


class _PeriodicSamples(sympy.Function):
    """Common part: n values at the phases 0, 1/n, ..., (n-1)/n turns, repeated with period 1."""

    @classmethod
    def eval(cls, phase: sympy.Expr, *values: sympy.Expr) -> sympy.Expr | None:
        if not values:
            raise ModelError(cls.__name__, "has a phase but no values", "give one value or more after the phase")
        for argument in (phase, *values):
            if argument.is_Atom and (argument is sympy.nan or argument.is_real is False):
                raise ModelError(cls.__name__, f"{argument} is not a finite real number", "give finite real numbers or symbols")
        if not phase.is_Number:
            return None
        count = len(values)
        # The cut lies in the middle of the last interval, so that no sample has its neighbors on two sides of it.
        position = count * (phase - sympy.floor(phase + sympy.Rational(1, 2 * count)))
        left = int(sympy.floor(position))
        return cls._between(values[left % count], values[(left + 1) % count], values[(left - 1) % count], position - left)

    @classmethod
    def _between(cls, left: sympy.Expr, right: sympy.Expr, before: sympy.Expr, part: sympy.Expr) -> sympy.Expr:
        """Value at ``part`` (from 0 to below 1) of the interval from ``left`` to ``right``; ``before`` comes before ``left``."""
        raise NotImplementedError

    def _eval_evalf(self, prec: int) -> sympy.Expr | None:
        phase, *values = self.args
        if not phase.is_number:
            return None
        digits = prec_to_dps(prec)
        # The whole turns go first: a far phase would otherwise cancel all the digits asked for.
        return self.func((phase - sympy.floor(phase)).evalf(digits), *values).evalf(digits)

    def _eval_is_real(self) -> bool | None:
        return True if all(argument.is_real for argument in self.args) else None

    def _with_unit(self, argindex: int) -> sympy.Expr:
        """Derivative with respect to one value: the same function of a unit sample (linear in the values)."""
        if not 2 <= argindex <= len(self.args):
            raise ArgumentIndexError(self, argindex)
        return self.func(self.args[0], *(int(index == argindex) for index in range(2, len(self.args) + 1)))


class PeriodicSteps(_PeriodicSamples):
    """Piecewise constant function of phase [turns]: value k from k/n to (k+1)/n, the mean of both sides at the jumps.

    The slope of a :class:`PeriodicTable`. Its own derivative with respect to phase is 0: the jumps are not counted. Raises
    ModelError without values, or for a value that is not a finite real number.

    >>> PeriodicSteps(sympy.Rational(1, 3), 5, 7), PeriodicSteps(sympy.Rational(1, 2), 5, 7)
    (5, 6)
    """

    @classmethod
    def _between(cls, left: sympy.Expr, right: sympy.Expr, before: sympy.Expr, part: sympy.Expr) -> sympy.Expr:
        return left if part else (before + left) / 2

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        return sympy.S.Zero if argindex == 1 else self._with_unit(argindex)


class PeriodicTable(_PeriodicSamples):
    """Linear interpolation of n equally spaced samples over one period, ``PeriodicTable(phase, v_0, ..., v_{n-1})``.

    v(phase) = (1 - w) v_k + w v_{k+1} with k = floor(n·phase), w = n·phase - k, indices modulo n; phase in turns, any real
    number. The unit is that of the values. Linear in the values; its derivative with respect to the phase is a
    :class:`PeriodicSteps` of n (v_{k+1} - v_k). Raises ModelError without values, or for one that is not a finite real number.

    >>> PeriodicTable(sympy.Rational(-1, 8), 0, 10, 20, 30)  # halfway between the last sample and the first
    15
    >>> phase, a, b = sympy.symbols("phase a b")
    >>> PeriodicTable(phase, a, b).diff(phase)
    PeriodicSteps(phase, -2*a + 2*b, 2*a - 2*b)
    """

    @classmethod
    def _between(cls, left: sympy.Expr, right: sympy.Expr, before: sympy.Expr, part: sympy.Expr) -> sympy.Expr:
        return (1 - part) * left + part * right

    def fdiff(self, argindex: int = 1) -> sympy.Expr:
        if argindex != 1:
            return self._with_unit(argindex)
        phase, *values = self.args
        following = [*values[1:], values[0]]
        return PeriodicSteps(phase, *(len(values) * (after - value) for value, after in zip(values, following, strict=True)))
