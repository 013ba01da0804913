"""The truck of ``modelgen.drivelines`` in the terms of every peer: written by hand from numbers, as each one's manual advises."""
