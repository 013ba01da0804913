"""Timings are run by hand; the peers they compare with are not installed for the tests."""

collect_ignore_glob = ["peers/*", "against_peers.py"]
