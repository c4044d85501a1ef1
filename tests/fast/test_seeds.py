"""Every random choice of a run comes from the seed in its case."""

from __future__ import annotations

import ast

from debrisflow._jit import PACKAGE

TREES = {path: ast.parse(path.read_text(encoding="utf-8")) for path in PACKAGE.rglob("*.py")}


def test_all_generators_start_from_the_seed_of_the_case():
    found = [
        ast.unparse(node)
        for tree in TREES.values()
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and "default_rng" in ast.unparse(node.func)
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
