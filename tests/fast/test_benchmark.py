"""The table of the benchmark in the documentation."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

RESULTS = {
    "dam2d_20k": {
        "1": {
            "seconds_per_step": 0.0364,
            "fluid": 20000,
            "particles": 24000,
            "split": {"neighbors": 0.01, "pressure solution": 0.025},
        }
    }
}


@pytest.fixture
def benchmark(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "scripts")
    return import_module("benchmark")


def test_phases_are_compared_with_the_neighbor_lists(benchmark):
    *_, row = benchmark.table_lines(RESULTS)
    assert row == "| `dam2d_20k` | 1 | 20,000 | 0.0364 | 0.0100 | pressure solution 2.50 |"


def test_the_table_replaces_the_one_between_its_markers(benchmark, tmp_path):
    page = tmp_path / "performance.md"
    page.write_text(f"before\n\n{benchmark.BEGIN}\nold\n{benchmark.END}\n\nafter\n")
    for _ in range(2):
        benchmark.write_docs(RESULTS, page)
        text = page.read_text()
        assert text.startswith(f"before\n\n{benchmark.BEGIN}\nSeconds of wall time")
        assert text.endswith(f"2.50 |\n{benchmark.END}\n\nafter\n")
        assert "old" not in text


def test_a_page_without_markers_gets_them(benchmark, tmp_path):
    benchmark.write_docs(RESULTS, tmp_path / "docs" / "performance.md")
    text = (tmp_path / "docs" / "performance.md").read_text()
    assert text.count(benchmark.BEGIN) == text.count(benchmark.END) == 1
