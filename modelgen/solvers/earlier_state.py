"""The last state of an earlier run in the coordinates of another model of the same parts.

Below ``case``. Which relative angles are states depends on the order of the elements and on the reference shaft; the angles and
speeds of the nodes do not. They are carried over flange by flange, and the elements' own states by name.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from modelgen.lowering import Compiled


def in_states_of(model: Compiled, earlier: Compiled | None, final: Mapping[str, float]) -> Mapping[str, float]:
    """The state ``final`` of a run of ``earlier`` by the names of the states of ``model``.

    It is given back as it is where the names are the same already, and where the parts are not: the names then say what differs.
    """
    if earlier is None or set(final) == set(model.states):
        return final
    old, new = earlier.equations, model.equations
    node_of = {flange: index for index, node in enumerate(old.nodes) for flange in node.flanges}
    own = [state.name for state in new.states if state.kind == "own"]
    if set(node_of) != {flange for node in new.nodes for flange in node.flanges} or not set(own) <= set(final):
        return final
    given = earlier.parameters.vector()
    found = (np.asarray(each).ravel() for each in earlier.mean_model.angles([final[name] for name in earlier.states], given))
    angle, rate = found
    at_nodes = earlier.mean_model.nodes_at(given)
    rows = [node_of[node.flanges[0]] for node in new.nodes]
    p = model.parameters.vector()
    arms = model.mean_model.nodes_at(p)
    speed = (at_nodes @ (rate + earlier.mean_model.ratios_at(given).speed))[rows]
    angles = np.linalg.lstsq(arms, (at_nodes @ angle)[rows], rcond=None)[0]
    speeds = np.linalg.lstsq(arms, speed - arms @ model.mean_model.ratios_at(p).speed, rcond=None)[0]
    state = model.mean_model.coordinates(angles, speeds, [final[name] for name in own], p)
    return dict(zip(model.states, np.asarray(state).ravel().tolist(), strict=True))
