"""Attribution of changes by real runs: cells of the factorial of suspects, delta debugging, bisection."""
