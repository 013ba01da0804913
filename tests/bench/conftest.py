"""Timings are run by hand; the peers they compare with are not installed for the tests."""

collect_ignore_glob = [
    "peers/*", "against_peers.py", "curves.py", "diagram.py", "diagram_figure.py", "models.py", "questions.py", "report.py",
    "scaling.py",
]  # fmt: skip
