"""The printed equations: what stands in them, and that GitHub, notebooks and LaTeX can read them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import pytest
import sympy

from modelgen import (
    Driveline,
    Element,
    Flange,
    GearPair,
    GroundDamper,
    GroundSpring,
    HarmonicTorque,
    Inertia,
    Param,
    RigidGear,
    Shaft,
    State,
    SteppedTorque,
    assemble,
    load,
    quantity,
)
from modelgen.equations import system


def _own_elements() -> tuple[type[Element], ...]:
    class SliderCrank(Element):
        crank = Flange()
        radius = Param("m", positive=True, doc="crank radius")
        mass = Param("kg", positive=True, doc="M")

        def kinetic_energy(self) -> Any:
            return self.mass * (self.radius * sympy.sin(self.crank.angle) * self.crank.speed) ** 2 / 2

    class OilShaft(Element):
        a, b = Flange(), Flange()
        stiffness = Param("N*m/rad", positive=True)
        oil_level = Param(positive=True, doc="share of the housing that oil fills")
        inner = State("N*m", scale=1.0)

        @quantity("rad")
        def twist(self) -> Any:
            """Angle across the shaft."""
            return self.a.angle - self.b.angle

        def torques(self) -> Mapping[Any, Any]:
            torque = self.stiffness * self.oil_level * self.twist + self.inner
            return {self.a: -torque, self.b: torque}

        def rates(self) -> Mapping[Any, Any]:
            return {self.inner: self.stiffness * (self.a.speed - self.b.speed)}

    return SliderCrank, OilShaft


@pytest.fixture(scope="module")
def everything() -> Any:
    """Equations with every element and most of their switches."""
    slider, oil = _own_elements()
    mesh = {"module": "4 mm", "teeth_a": 21, "teeth_b": 63}
    rows = {"stiffness_cosine": (1e7, 2e7, 3e7, 4e7), "stiffness_sine": (1e6, 2e6, 3e6, 4e6)}
    elements = [
        *(Inertia(name, inertia=1.0) for name in ("engine", "fan", "pinion", "wheel", "pump", "drum", "tail", "tip")),
        RigidGear("belt", "engine", "fan", teeth_a=20, teeth_b=35),
        Shaft("coupling", "engine", "pinion", stiffness=9e4, damping="loss_factor", loss_factor=0.1, reference_frequency=100.0),
        GearPair(
            "first", "pinion", "wheel", mesh="table", stiffness_table=(1e8, 2e8, 3e8, 2e8, 1e8, 1e8), damping="literal", **mesh
        ),
        GearPair(
            "second", "wheel", "drum", mean_stiffness=8e8, stiffness_orders=(1, 2, 4, 6), viscous="contact_only", **rows, **mesh
        ),
        GearPair("third", "drum", "tail", mesh="rectangular", stiffness_high=2e8, stiffness_low=1e8, contact_ratio=1.5, **mesh),
        Shaft("pump_shaft", "wheel", "pump", stiffness=6e4, damping="value", damping_coefficient=3.0),
        HarmonicTorque("firing", "engine", mean=300.0, cosine=[500.0, 20.0], base="firing_order"),
        SteppedTorque("step", "pump", after=10.0, shape="ramp", duration=0.1),
        GroundDamper("drag", "fan", damping="loss"),
        slider("slider", "pump", radius=0.1, mass=2.0),
        oil("soft", "pump", "tip", stiffness=100.0, oil_level=0.4),
    ]
    line = Driveline(
        "everything",
        elements=elements,
        speed="1500 rpm",
        reference="engine",
        drifts=True,
        description="# All *elements* for 5 $ & <more>,\n100 % of them_all",
        parameters={"loss": "0.3 N*m*s/rad"},
        bases={"firing_order": ("engine", 2)},
    )
    equations = assemble(line)
    yield equations
    for each in (slider, oil):
        del Element.vocabulary[each.kind]


@pytest.fixture(scope="module")
def truck() -> str:
    return assemble(load("fracturing-truck")).markdown()


@pytest.fixture(scope="module")
def documents(everything: Any, truck: str) -> dict[str, str]:
    locked = Driveline(
        "locked",
        elements=[
            Inertia("disk", inertia=1.0),
            Inertia("rim", inertia=2.0),
            Shaft("arm", "disk", "rim", stiffness=5.0, damping="modal", damping_ratio=0.02),
            GroundSpring("wire", "disk", stiffness=10.0),
        ],
    )
    x, v, mu = sympy.symbols("x v mu")
    plain = system(
        {x: 2.0, v: 0.0}, {x: v, v: mu * (1 - x**2) * v - x}, {mu: 5.0}, {"energy": x**2 / 2 + v**2 / 2}, "van_der_pol"
    )
    return {
        "truck": truck,
        "everything": everything.markdown(),
        "locked": assemble(locked).markdown(),
        "plain": plain.markdown(),
    }


def formulas(text: str) -> list[str]:
    """All formulas of a Markdown text, in blocks and in the line."""
    blocks = re.findall(r"^\$\$\n(.*?)\n\$\$$", text, re.M | re.S)
    rest = re.sub(r"^\$\$\n(.*?)\n\$\$$", "", text, flags=re.M | re.S)
    return blocks + re.findall(r"(?<!\\)\$([^$\n]+)(?<!\\)\$", rest)


# -- what GitHub, notebooks and LaTeX can read -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["truck", "everything", "locked", "plain"])
def test_formulas_hold_nothing_that_github_breaks(documents: dict[str, str], name: str) -> None:
    found = formulas(documents[name])
    assert found
    for formula in found:
        # GitHub removes the backslash before punctuation, refuses \operatorname, and may take "}_" for emphasis.
        assert not re.search(r"\\[_,:;!{}*]|\\operatorname|\}_|(?<! )<|<(?! )", formula), formula
        assert not re.search(r"sympy|Symbol|Piecewise|relative_|\w\.\w|__", formula), formula
        depth = 0
        for bracket in re.findall(r"[{}]", formula):
            depth += 1 if bracket == "{" else -1
            assert depth >= 0, formula
        assert depth == 0, formula
        assert len(re.findall(r"\\left\b", formula)) == len(re.findall(r"\\right\b", formula)), formula
        environments = re.findall(r"\\(begin|end)\{(\w+)\}", formula)
        opened = []
        for what, environment in environments:
            if what == "begin":
                opened.append(environment)
            else:
                assert opened.pop() == environment, formula
        assert not opened, formula


@pytest.mark.parametrize("name", ["truck", "everything", "locked", "plain"])
def test_blocks_stand_alone_and_tables_are_whole(documents: dict[str, str], name: str) -> None:
    text = documents[name]
    assert text.endswith("\n")
    assert not text.endswith("\n\n")
    paragraphs = text.removesuffix("\n").split("\n\n")
    for paragraph in paragraphs:
        lines = paragraph.split("\n")
        if "$$" in paragraph:
            assert (lines[0], lines[-1]) == ("$$", "$$")
            assert paragraph.count("$$") == 2
        if paragraph.startswith("|"):
            columns = {len(re.findall(r"(?<!\\)\|", line)) for line in lines}
            assert len(columns) == 1, paragraph
            assert len(lines) >= 3


def test_free_text_of_the_user_stays_text(documents: dict[str, str], everything: Any) -> None:
    shown = r"\# All \*elements\* for 5 \$ &amp; &lt;more\>, 100 % of them\_all"
    assert documents["everything"].split("\n\n")[1] == shown
    assert r"\# All *elements* for 5 \$ \& <more>, 100 \% of them\_all" in everything.latex()


def test_the_latex_fragment_is_balanced(everything: Any) -> None:
    text = everything.latex()
    opened = []
    for what, environment in re.findall(r"\\(begin|end)\{([\w*]+)\}", text):
        if what == "begin":
            opened.append(environment)
        else:
            assert opened.pop() == environment
    assert not opened
    assert text.isascii()
    for table in re.findall(r"\\begin\{longtable\}\{(\w+)\}\n(.*?)\\end\{longtable\}", text, re.S):
        rows = [row for row in table[1].split("\n") if row.endswith(r"\\")]
        assert {len(re.findall(r"(?<!\\)&", row)) for row in rows} == {len(table[0]) - 1}
    assert not re.search(r"(?<!\\)_(?![{\w])", text)


# -- what stands in them ------------------------------------------------------------------------------------------------------


def block_with(text: str, start: str) -> str:
    """The formulas in which some row starts with a text."""
    return next(each for each in formulas(text) if re.search(rf"^(&\\quad )?{re.escape(start)}", each, re.M))


def test_laws_of_the_truck_read_like_a_textbook(truck: str) -> None:
    shaft = block_with(truck, "u &=")
    assert r"c &= 2 \zeta \sqrt{\frac{k J_{a} J_{b}}{J_{a} + J_{b}}} \\" in shaft
    assert r"T &= k u + c \dot u \\" in shaft
    assert r"T_{\text{on a}} &= - T \\" in shaft
    mesh = block_with(truck, "F &=")
    assert r"k_{m}(t) &= k_{1} + \sum_{n=1}^{10} \left(k_{n+1} \cos{\left(n \omega_{m} t \right)} + k_{n+11} \sin" in mesh
    assert r"e(t) &= e_{0} + e_{r} \sin{\left(\omega_{m} t + \varphi_{e} \right)} \\" in mesh
    assert r"c_{m}(t) &= 2 \xi \sqrt{\frac{J_{a} J_{b} k_{m}}{J_{a} r_{b}^{2} + J_{b} r_{a}^{2}}} \\" in mesh
    assert r"f(\delta) &= \begin{cases} \delta - b & \text{if } \delta \geq b \\" in mesh
    assert r"F &= k_{m} f(\delta) + c_{m} \dot{\delta} \\" in mesh
    assert mesh.index(r"\delta &=") < mesh.index(r"\dot{\delta} &=") < mesh.index(r"f(\delta) &=") < mesh.index("F &=")
    torque = r"\sum_{n=1}^{24} \left(a_{n} \sin{\left(n \left(\omega_{0} t + \varphi\right) \right)} + b_{n} \cos{\left("
    assert torque in block_with(truck, "T(t) &=")


def test_every_node_of_the_truck_has_its_equation(truck: str) -> None:
    nodes = block_with(truck, r"J_{\text{damper}}")
    assert nodes.count(r"\ddot\theta") == 16
    row = r"\ddot\theta_{\text{throw 1}} &= T_{\text{damper shaft}} + T_{\text{firing 1}}(t) - T_{\text{crank 1}} \\"
    assert row in nodes
    pinion = r"&= T_{\text{propeller shaft}} - r_{a,\text{pump mesh}} F_{\text{pump mesh}} \\"
    assert pinion in nodes


def test_the_truck_is_a_few_pages_with_each_element_once(truck: str) -> None:
    assert len(truck.splitlines()) < 450
    assert truck.count("### ") == 5
    rows = re.findall(r"^\| `crank_1` \|.*$", truck, re.M)
    assert rows == ["| `crank_1` | `throw_1` | `throw_2` | 10.5·10⁶ |"]
    assert r"All of them: $\zeta$ = `zeta` = 0.035." in truck
    assert "$s$ = balanced." in truck


def test_base_frequencies_are_exact(truck: str) -> None:
    # 26/46 and 17/108 teeth: 26*17/(46*108) = 221/2484, and all repeats after 2484 engine turns (78.4 s at 1900 rpm).
    assert re.search(r"^\| `pump_crank` \| 221/2484 \| .* \| 2.81736 \| `plunger_1` … `plunger_3` \|$", truck, re.M)
    assert re.search(r"^\| `pump_mesh.contact` \| 221/23 \| .* \| 304.275 \| `pump_mesh` \|$", truck, re.M)
    assert "repeat together after 2484 turns of `flywheel`, that is 78.4421 s." in truck
    assert "| `bull_gear` | 221/2484 | 169.042 | `pump_crank_end_1.a`, `pump_mesh.b` |" in truck


def test_the_rigid_rotation_and_the_states_are_told(truck: str) -> None:
    assert "No law sees the rigid rotation" in truck
    assert r"| `flywheel.angle_deviation` | rad | $\theta_{\text{flywheel}} - \Omega t$ |" in truck
    approach = r"$r_{a,\text{pump mesh}} \theta_{\text{pump pinion}} - r_{b,\text{pump mesh}} \theta_{\text{bull gear}}$ |"
    assert f"| `pump_mesh.approach` | m | {approach}" in truck


def test_parameters_stand_with_their_values(truck: str) -> None:
    assert "| `xi` | 0.1 | — |" in truck
    assert "| row | `firing_sine` [N·m] | `firing_cosine` [N·m] |" in truck
    assert "| 24 | 2.6114 | -0.270948 |" in truck
    assert re.search(r"^\| 1 \| 2.46\d+·10⁹ \| 4.9\d+·10⁹ \|$", truck, re.M), "mean mesh stiffness from the teeth"


def test_orders_that_skip_are_listed(documents: dict[str, str]) -> None:
    text = documents["everything"]
    rows = r"k_{0} + \sum_{i=1}^{4} \left(a_{i} \cos{\left(n_i \omega_{m} t \right)} + b_{i} \sin{\left(n_i \omega_{m} t"
    assert rows in block_with(text, "k_{m}(t) &= k_{0}")
    assert r"with $n_1, \ldots, n_{4} = 1, 2, 4, 6$" in text


def test_few_rows_are_written_out(documents: dict[str, str]) -> None:
    firing = block_with(documents["everything"], r"T(t) &= s \left(T_{0} + b_{1}")
    assert r"b_{2} \cos{\left(2 \omega_{0} t + 2 \varphi \right)}" in firing
    assert r"\sum" not in firing


def test_switches_change_the_printed_law(documents: dict[str, str]) -> None:
    text = documents["everything"]
    assert r"c &= \frac{k \eta}{\omega_{\text{ref}}}" in text
    assert r"\mathrm{table}\left(\frac{\omega_{m} t}{2 \pi};\ k_{1}, k_{2}, \ldots, k_{6}\right)" in text
    assert r"k_{\text{min}} & \text{otherwise}" in text
    assert r"\text{if } \delta + \min\left(0, \frac{c_{m} \dot{\delta}}{k_{m}}\right) \geq b \\" in text
    assert r"T(t) &= T_{0} + \left(T_{1} - T_{0}\right) \min\left(1, \max\left(0, \frac{t - t_{0}}{\tau}\right)\right) \\" in text


def test_rigid_gears_and_varying_inertia_in_the_node_equations(documents: dict[str, str]) -> None:
    text = documents["everything"]
    nodes = block_with(text, r"\left(J_{\text{engine}}")
    assert (
        r"\left(J_{\text{engine}} + \frac{J_{\text{fan}} z_{a,\text{belt}}^{2}}{z_{b,\text{belt}}^{2}}\right) \ddot\theta_{"
        in nodes
    )
    assert r"r_{\text{slider}}^{2} M_{\text{slider}} \sin^{2}{\left(\theta_{\text{pump}} \right)}\right) \ddot\theta_{" in nodes
    assert r"- \frac{z_{a,\text{belt}} T_{\text{drag}}}{z_{b,\text{belt}}}" in nodes
    assert r"\theta_{\text{fan}} &= \frac{z_{a,\text{belt}} \theta_{\text{engine}}}{z_{b,\text{belt}}}" in text
    assert "| `fan` | 4/7 | 857.143 | `belt.b`, `drag` |" in text
    assert "Lagrange" in text


def test_long_sums_are_broken(documents: dict[str, str]) -> None:
    assert re.search(r"^&\\quad [-+] ", documents["everything"], re.M)


def test_own_states_and_unknown_names(documents: dict[str, str]) -> None:
    text = documents["everything"]
    assert r"\dot{\text{inner}} &= k \left(\omega_{a} - \omega_{b}\right)" in text
    assert r"| $\text{oil level}$ | `oil_level` | — | share of the housing that oil fills |" in text
    assert "then 1 state of the elements' own." in text
    assert "| `soft.inner` | N·m | 0 |" in text


def test_a_locked_driveline_with_modal_damping(documents: dict[str, str]) -> None:
    text = documents["locked"]
    row = r"J_{\text{disk}} \ddot\theta_{\text{disk}} &= - T_{\text{arm}} - T_{\text{wire}} + T_{\text{modal},\text{disk}}"
    assert row in text
    assert r"$\zeta$ = `arm.damping_ratio`" in text
    assert "States: 2 relative angles, then their rates." in text
    assert r"| `wire.twist` | rad | $\theta_{\text{disk}}$ |" in text
    assert "rpm" not in text
    assert "Base frequencies" not in text


def test_a_plain_system(documents: dict[str, str]) -> None:
    text = documents["plain"]
    assert text.startswith("# Equations: van_der_pol\n")
    assert "\\dot x &= v \\\\\n\\dot v &= \\mu v \\left(1 - x^{2}\\right) - x\n" in text
    assert r"\text{energy} &= \frac{x^{2}}{2} + \frac{v^{2}}{2}" in text
    assert "| `mu` | 5 | — |" in text


def test_symbols_that_collide_fall_back_to_names() -> None:
    class Twins(Element):
        flange = Flange()
        stiffness = Param("N*m/rad", positive=True)
        k = Param("N*m/rad", positive=True)

        def torques(self) -> Mapping[Any, Any]:
            return {self.flange: -(self.stiffness + self.k) * self.flange.angle}

    line = Driveline("twins", elements=[Inertia("disk", inertia=1.0), Twins("spring", "disk", stiffness=1.0, k=2.0)])
    try:
        text = assemble(line).markdown()
    finally:
        del Element.vocabulary[Twins.kind]
    assert r"T_{\text{on the node}} &= - \theta \left(k + \text{k}\right)" in text
