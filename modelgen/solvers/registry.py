"""draft"""
from modelgen.solvers.adaptive_rk4 import solve_rk4
SOLVERS={"rk4":solve_rk4}
def solve(p,n,o): return SOLVERS[n](p,o)
