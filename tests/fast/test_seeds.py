"""Every random choice of a run comes from the seed in its case, those of a study from its file."""

from __future__ import annotations

import ast

from debrisflow._jit import PACKAGE

ALL = {path: ast.parse(path.read_text(encoding="utf-8")) for path in PACKAGE.rglob("*.py")}
STUDIES = {path: tree for path, tree in ALL.items() if path.is_relative_to(PACKAGE / "study")}
TREES = {path: tree for path, tree in ALL.items() if path not in STUDIES}
GENERATORS = ("np.random.default_rng", "np.random.RandomState")


def calls_of(trees):
    """Return all calls in some sources, in words."""
    nodes = (node for tree in trees.values() for node in ast.walk(tree))
    return [node for node in nodes if isinstance(node, ast.Call)]


def test_all_generators_start_from_the_seed_of_the_case():
    found = [
        ast.unparse(node) for node in calls_of(TREES) if "default_rng" in ast.unparse(node.func)
    ]
    assert len(found) >= 3
    assert [call for call in found if "case.particles.seed" not in call] == []


def test_nothing_else_is_drawn_at_random():
    drawn = []
    for path, tree in TREES.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                drawn += [(path, n.name) for n in node.names if n.name in ("random", "secrets")]
            elif isinstance(node, ast.ImportFrom) and node.module in ("random", "secrets"):
                drawn.append((path, node.module))
            elif isinstance(node, ast.Attribute) and "random." in ast.unparse(node):
                drawn.append((path, ast.unparse(node)))
    other = [one for one in drawn if one[1] not in ("np.random.default_rng", "np.random.Generator")]
    assert other == []


def test_all_generators_of_a_study_start_from_a_seed():
    made = [node for node in calls_of(STUDIES) if ast.unparse(node.func) in GENERATORS]
    assert len(made) >= 5
    for node in made:
        (seed,) = map(ast.unparse, node.args)
        assert "seed" in seed
    samplers = [
        node
        for node in calls_of(STUDIES)
        if ast.unparse(node.func) in ("qmc.LatinHypercube", "qmc.Sobol")
    ]
    assert len(samplers) >= 2
    for node in samplers:
        given = {word.arg: ast.unparse(word.value) for word in node.keywords}
        assert "seed" in given["rng"]
