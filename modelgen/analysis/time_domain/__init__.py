"""A run over time, read as measured: from when on it is settled (``window``), and how large its ``angles`` and mesh forces are.

Below ``linear``, whose slowest mode says how long a transient lasts.
"""
