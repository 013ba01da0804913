"""What holds for every test: figures are drawn without a screen, here and in the processes that tests start."""

from __future__ import annotations

import os

# Before any test module imports Matplotlib, which reads it once.
os.environ["MPLBACKEND"] = "Agg"
