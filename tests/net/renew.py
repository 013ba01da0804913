"""Makes the net anew: ``python -m tests.net.renew``, of every question, or of those whose name holds one of the words given.

Renew only what changed on purpose, in a commit of its own that says why. With ``--full`` the digests of the full settings.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from .figures import figures_of, write
from .questions import Question, ask, full_questions, short_questions

HERE = Path(__file__).parent
SHORT, FULL = HERE / "short", HERE / "full"


def renew(questions: list[Question], folder: Path, rows: bool) -> None:
    """Asks and writes; what is not asked any more is deleted by whoever deletes the question."""
    for question in questions:
        begun = time.perf_counter()
        with tempfile.TemporaryDirectory() as temporary:
            printed, out = ask(question, Path(temporary))
            found = figures_of(printed, out, question.words)
        for old in folder.glob(f"{question.name}.*"):
            if not any(old.name.startswith(f"{other.name}.") and len(other.name) > len(question.name) for other in questions):
                old.unlink()
        write(found, folder, question.name, rows)
        print(f"{question.name}: {time.perf_counter() - begun:.1f} s", flush=True)


def main() -> None:
    """Short settings by default."""
    words = [each for each in sys.argv[1:] if each != "--full"]
    full = "--full" in sys.argv
    questions = full_questions() if full else short_questions()
    asked = [each for each in questions if not words or any(word in each.name for word in words)]
    renew(asked, FULL if full else SHORT, rows=not full)


if __name__ == "__main__":
    main()
