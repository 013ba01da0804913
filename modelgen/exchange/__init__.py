"""Others: what comes from makers and instruments, and what goes back to them.

``delimited_text`` is the border where foreign tables come in; ``mass_elastic`` reads a maker's table as a driveline,
``equivalent_system`` writes a driveline as one. Stands below ``solvers``; ``analysis.measurements`` reads recordings through it.
"""
