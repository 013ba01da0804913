"""modelgen generate: whole folders or none, and a check that notices every way in which they can go stale."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from modelgen.cli import generate_check, generate_folder
from modelgen.lowering.switching import Switching

from .conftest import Invoke

ROOT = Path(__file__).resolve().parents[2]
FILES = ["equations.md", "manifest.json", "two-disks.c", "two-disks.h", "two-disks_solver.c"]


@pytest.fixture(scope="module")
def written(invoke: Invoke, two_disks: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a model file and what was generated from it."""
    place = tmp_path_factory.mktemp("generated")
    shutil.copy(two_disks, place / "two_disks.toml")
    result = invoke("generate", place / "two_disks.toml", "--out", place / "c")
    assert result.exit_code == 0, result.stderr
    return place


@pytest.fixture
def place(written: Path, tmp_path: Path) -> Path:
    """A copy of it to spoil: manifests count paths from their folder, so it stays fresh."""
    return Path(shutil.copytree(written, tmp_path / "copy"))


def manifest_of(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "manifest.json").read_text(encoding="utf-8"))


def test_the_folder_holds_everything_and_nothing_else(written: Path) -> None:
    assert sorted(each.name for each in (written / "c").iterdir()) == FILES
    assert sorted(each.name for each in written.iterdir()) == ["c", "two_disks.toml"]
    manifest = manifest_of(written / "c")
    assert manifest["source"] == "../two_disks.toml"
    assert sorted([*manifest["files"], "manifest.json"]) == FILES
    for name, expected in manifest["files"].items():
        assert hashlib.sha256((written / "c" / name).read_bytes()).hexdigest() == expected


def test_a_fresh_folder_is_fresh_wherever_it_stands(invoke: Invoke, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    result = invoke("generate", "--check", "c")
    assert (result.exit_code, result.stdout) == (0, "c: fresh\n")


def test_without_folders_all_of_generated_are_checked(invoke: Invoke, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    result = invoke("generate", "--check")
    assert result.exit_code == 2
    assert "there is no folder in generated/; name one" in result.stderr
    (place / "generated").mkdir()
    (place / "generated/note.txt").write_text("no folder")
    shutil.copytree(place / "c", place / "generated/c")
    shutil.copy(place / "two_disks.toml", place / "generated")
    assert invoke("generate", "--check").stdout == "generated/c: fresh\n"


def test_another_process_writes_the_same_bytes(place: Path) -> None:
    order = [sys.executable, "-m", "modelgen", "generate", "two_disks.toml", "--out", "again"]
    environment = {**os.environ, "PYTHONHASHSEED": "7", "PYTHONPATH": str(ROOT)}
    subprocess.run(order, cwd=place, env=environment, check=True, capture_output=True)
    for name in FILES:
        assert (place / "again" / name).read_bytes() == (place / "c" / name).read_bytes(), name


def edited(place: Path) -> None:
    path = place / "c/two-disks.c"
    path.write_bytes(path.read_bytes() + b" ")


def removed(place: Path) -> None:
    (place / "c/equations.md").unlink()


def added(place: Path) -> None:
    (place / "c/more.c").write_text("int more;\n")


def edited_with_its_hash(place: Path) -> None:
    edited(place)
    manifest = (place / "c/manifest.json").read_text()
    old = manifest_of(place / "c")["files"]["two-disks.c"]
    new = hashlib.sha256((place / "c/two-disks.c").read_bytes()).hexdigest()
    (place / "c/manifest.json").write_text(manifest.replace(old, new))


def spaced_manifest(place: Path) -> None:
    path = place / "c/manifest.json"
    path.write_text(path.read_text() + "\n")


def heavier(place: Path) -> None:
    path = place / "two_disks.toml"
    path.write_text(path.read_text().replace("3 kg*m^2", "3.00000000001 kg*m^2"))


def described(place: Path) -> None:
    path = place / "two_disks.toml"
    path.write_text(path.read_text().replace('name = "two-disks"', 'name = "two-disks"\ndescription = "Another."'))


def with_one_more_element(place: Path) -> None:
    path = place / "two_disks.toml"
    more = '[elements.drag]\nkind = "harmonic_torque"\nflange = "load"\nmean = "0 N*m"\n'
    path.write_text(path.read_text() + more)


def without_its_model(place: Path) -> None:
    (place / "two_disks.toml").unlink()


def changed(*keys: Any) -> Callable[[Path], None]:
    """One number of the manifest a little larger."""

    def change(place: Path) -> None:
        data = manifest_of(place / "c")
        holder = data
        for key in keys[:-1]:
            holder = holder[key]
        holder[keys[-1]] = holder[keys[-1]] * (1 + 1e-8) + 1e-8
        (place / "c/manifest.json").write_text(json.dumps(data))

    return change


STALE = [
    (edited, "'two-disks.c' was edited after it was written"),
    (removed, "'equations.md' is missing"),
    (added, "'more.c' was not written by modelgen"),
    (edited_with_its_hash, "'two-disks.c' comes out otherwise, at its end"),
    (spaced_manifest, "'manifest.json' comes out otherwise"),
    (heavier, "parameter 'engine.inertia' was 3 and is now 3.00000000001"),
    (heavier, "the text of the model has changed"),
    (described, "the text of the model has changed"),
    (with_one_more_element, "the model has now"),
    (without_its_model, "the model cannot be generated"),
    (changed("probes", 2, "rates", 0), "probe 3, rate of "),
    (changed("probes", 0, "outputs", 1), "probe 1, '"),
    (changed("case", "start", 0), "start of '"),
    (changed("case", "scale", 1), "scale of '"),
    (changed("case", "end"), "the default case runs now to"),
]


@pytest.mark.parametrize(("spoil", "words"), STALE)
def test_what_is_stale_is_named_with_the_command_that_repairs_it(
    spoil: Callable[[Path], None], words: str, invoke: Invoke, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(place)
    spoil(place)
    result = invoke("generate", "--check", "c")
    assert result.exit_code == 1
    assert words in result.stderr
    assert "repair with: modelgen generate two_disks.toml --out c --replace" in result.stderr


def test_the_repair_repairs(invoke: Invoke, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(place)
    heavier(place)
    assert invoke("generate", "--check", "c").exit_code == 1
    assert invoke("generate", "two_disks.toml", "--out", "c", "--replace").exit_code == 0
    assert invoke("generate", "--check", "c").stdout == "c: fresh\n"


def test_other_tools_are_no_fault(invoke: Invoke, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    edited_with_its_hash(place)  # such as another casadi would write it
    now = generate_check.tools()
    monkeypatch.setattr(generate_check, "tools", lambda: {**now, "casadi": "9.9.9"})
    result = invoke("generate", "--check", place / "c")
    assert result.exit_code == 0, result.stderr
    assert f"fresh, bytes not compared (casadi {now['casadi']} then, 9.9.9 now)" in result.stdout


def test_rounding_of_another_machine_is_no_fault(invoke: Invoke, place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its numbers may differ in their last digits, and the bytes are still those of the manifest's numbers."""
    here = generate_check.default_case

    def elsewhere(model: Any) -> Any:
        case = here(model)
        return replace(case, scale=tuple(value * (1 + 3e-16) for value in case.scale))

    monkeypatch.setattr(generate_check, "default_case", elsewhere)
    result = invoke("generate", "--check", place / "c")
    assert result.exit_code == 0, result.stderr


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (None, "has no manifest.json; generate it"),
        ("{", "that is not one of ours"),
        ("[]", "that is not one of ours"),
        ("[" * 100_000, "that is not one of ours"),
        ('{"format": 2}', "has format 2, known is 1"),
        ('{"format": 1}', "that is not one of ours"),
        ('{"format": 1, "source": 3}', "that is not one of ours"),
    ],
)
def test_a_manifest_that_is_none(text: str | None, words: str, invoke: Invoke, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / "manifest.json").write_text(text)
    result = invoke("generate", "--check", tmp_path)
    assert result.exit_code == 2
    assert words in result.stderr


def test_names_in_a_manifest_lead_nowhere_else(invoke: Invoke, place: Path) -> None:
    path = place / "c/manifest.json"
    path.write_text(path.read_text().replace('"equations.md"', '"../two_disks.toml"'))
    result = invoke("generate", "--check", place / "c")
    assert result.exit_code == 1
    assert "'../two_disks.toml' is missing" in result.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "got 0 models; name one MODEL"),
        (("fracturing-truck", "two-disk-gear", "--out", "x"), "got 2 models; name one MODEL"),
        (("two-disk-gear",), "has no --out; name the folder to write"),
        (("two-disk-geer", "--out", "x"), "nearest is 'two-disk-gear'"),
        (("--check", "--out", "x"), "writes nothing, but --out or --replace is given"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    arguments: tuple[str, ...], words: str, invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = invoke("generate", *arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert not list(tmp_path.iterdir())


def test_only_what_modelgen_wrote_is_replaced(invoke: Invoke, place: Path) -> None:
    out, model = place / "c", place / "two_disks.toml"
    assert "exists and is not empty; take --replace" in invoke("generate", model, "--out", out).stderr
    (out / "mine.txt").write_text("mine")
    assert "holds 'mine.txt', which modelgen did not write" in invoke("generate", model, "--out", out, "--replace").stderr
    assert (out / "mine.txt").read_text() == "mine"


def test_a_failure_leaves_nothing_half_written(
    invoke: Invoke, two_disks: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = Path.write_bytes

    def fails(path: Path, content: bytes) -> int:
        if path.name == "manifest.json":
            raise OSError(28, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", fails)
    result = invoke("generate", two_disks, "--out", tmp_path / "new" / "c")
    assert result.exit_code == 2
    assert "cannot be written: No space left on device" in result.stderr
    assert not list(tmp_path.iterdir())


def test_laws_that_jump_have_no_c_yet(invoke: Invoke, two_disks: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pose = generate_folder.initial_value_problem

    def jumping(*arguments: Any) -> Any:
        problem, offset = pose(*arguments)
        return replace(problem, switching=Switching((), (), problem.rhs, problem.p.size)), offset

    monkeypatch.setattr(generate_folder, "initial_value_problem", jumping)
    result = invoke("generate", two_disks, "--out", tmp_path / "c")
    assert result.exit_code == 2
    assert "has laws that jump, and generated C locates no events yet" in result.stderr


ONE_DISK = """
format = 1
name = "one-disk"
[operation]
speed = "1200 rpm"
reference = "disk"
[elements.disk]
kind = "inertia"
inertia = "1 kg*m^2"
"""


def test_a_line_that_does_not_vibrate(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "one.toml").write_text(ONE_DISK)
    assert invoke("generate", tmp_path / "one.toml", "--out", tmp_path / "c").exit_code == 0
    header = (tmp_path / "c/one-disk.h").read_text()
    assert "#define one_disk_END 1.0\n" in header
    assert "one_disk_J = 1," in header
    assert invoke("generate", "--check", tmp_path / "c").exit_code == 0


def test_with_modal_damping_every_parameter_is_a_source(invoke: Invoke, two_disks: Path, tmp_path: Path) -> None:
    """The damping matrix rests on all masses and stiffnesses, and the C does not compute it."""
    damped = two_disks.read_text().replace(
        'damping = "value"\ndamping_coefficient = "20 N*m*s/rad"', 'damping = "modal"\ndamping_ratio = 0.02'
    )
    (tmp_path / "modal.toml").write_text(damped)
    result = invoke("generate", tmp_path / "modal.toml", "--out", tmp_path / "c")
    assert result.exit_code == 0, result.stderr
    text = (tmp_path / "c/two-disks.c").read_text()
    flags = text.split("is_source[two_disks_P] = {")[1].split("}")[0].split(",")
    assert [int(each) for each in flags[-4:]] == [0] * 4  # the matrix itself
    assert all(int(each) for each in flags[:-4])
