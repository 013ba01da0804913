"""The operations that generated C knows: one table, by CasADi's codes.

Part of the compiler. ``NUMBER`` operations are an infix sign or a function of the run-time header (``v_`` on lanes, ``s_`` on one
double); comparisons and logic give masks, which select without a branch. What is not here is refused by name.
"""

from __future__ import annotations

import casadi as ca

# Templates: {0}, {1} are operands, {f} is the prefix of the functions, "v_" or "s_".
ARITHMETIC = {
    ca.OP_ASSIGN: "{0}",
    ca.OP_ADD: "{0} + {1}",
    ca.OP_SUB: "{0} - {1}",
    ca.OP_MUL: "{0} * {1}",
    ca.OP_DIV: "{0} / {1}",
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "{0} + {0}",
    ca.OP_INV: "{f}all(1.0) / {0}",
}
FUNCTIONS = {
    ca.OP_EXP: "exp",
    ca.OP_LOG: "log",
    ca.OP_SQRT: "sqrt",
    ca.OP_SIN: "sin",
    ca.OP_COS: "cos",
    ca.OP_TAN: "tan",
    ca.OP_ASIN: "asin",
    ca.OP_ACOS: "acos",
    ca.OP_ATAN: "atan",
    ca.OP_SINH: "sinh",
    ca.OP_COSH: "cosh",
    ca.OP_TANH: "tanh",
    ca.OP_ASINH: "asinh",
    ca.OP_ACOSH: "acosh",
    ca.OP_ATANH: "atanh",
    ca.OP_ERF: "erf",
    ca.OP_LOG1P: "log1p",
    ca.OP_EXPM1: "expm1",
    ca.OP_FLOOR: "floor",
    ca.OP_CEIL: "ceil",
    ca.OP_FABS: "fabs",
    ca.OP_SIGN: "sign",
    ca.OP_POW: "pow",
    ca.OP_CONSTPOW: "pow",
    ca.OP_ATAN2: "atan2",
    ca.OP_FMIN: "fmin",
    ca.OP_FMAX: "fmax",
    ca.OP_FMOD: "fmod",
    ca.OP_COPYSIGN: "copysign",
    ca.OP_HYPOT: "hypot",
    ca.OP_REMAINDER: "remainder",
}
COMPARISONS = {ca.OP_LT: "{0} < {1}", ca.OP_LE: "{0} <= {1}", ca.OP_EQ: "{0} == {1}", ca.OP_NE: "{0} != {1}"}
LOGIC = {ca.OP_NOT: "not", ca.OP_AND: "and", ca.OP_OR: "or"}

SELECTION = frozenset({ca.OP_IF_ELSE_ZERO})
MASKS = frozenset({*COMPARISONS, *LOGIC})
OPERATIONS = frozenset({*ARITHMETIC, *FUNCTIONS, *MASKS, *SELECTION})
COMMUTATIVE = frozenset({ca.OP_ADD, ca.OP_MUL, ca.OP_EQ, ca.OP_NE, ca.OP_AND, ca.OP_OR, ca.OP_HYPOT})
