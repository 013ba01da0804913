"""Progress: plain lines where there is no terminal, a bar where there is one."""

from __future__ import annotations

import io

import pytest

from modelgen.cli import progress


def test_plain_lines_do_not_flood(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    with progress.Progress() as shown:
        shown.stage("simulate", measured=True)
        for step in range(300):
            now[0] = 0.1 * step
            shown.fraction(step / 300)
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == ["modelgen: simulate", "modelgen: simulate: 34 %", "modelgen: simulate: 67 %"]


def test_a_bar_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    screen = Terminal()
    monkeypatch.setattr("sys.stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with progress.Progress() as shown:
        shown.stage("read [red]model[/red]")
        shown.stage("simulate", measured=True)
        shown.fraction(0.5)
        shown.fraction(7.0)
    assert "read [red]model[/red]" in screen.getvalue()
    assert "100%" in screen.getvalue()
