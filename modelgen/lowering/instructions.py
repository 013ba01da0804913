"""The instruction list of an SX function, one operation after the other.

Part of ``lowering``, below all that reads a compiled function anew: the graph of the C generator, bounds, shapes of guards,
switches in time.
"""

from __future__ import annotations

from collections.abc import Iterator

import casadi as ca


def instructions(function: ca.Function) -> Iterator[tuple[int, list[int], list[int], float]]:
    """Code, places read, places written, and the number of a constant (else 0), in the order of evaluation.

    >>> x = ca.SX.sym("x")
    >>> [(ca.OP_INPUT == code, number) for code, _, _, number in instructions(ca.Function("f", [x], [x + 2.5]))][:2]
    [(True, 0.0), (False, 2.5)]
    """
    for index in range(function.n_instructions()):
        code = function.instruction_id(index)
        number = float(function.instruction_constant(index)) if code == ca.OP_CONST else 0.0
        yield code, function.instruction_input(index), function.instruction_output(index), number
