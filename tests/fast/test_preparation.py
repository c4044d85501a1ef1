"""Compiling in advance: which cases it runs, and that it only compiles what is not cached."""

from __future__ import annotations

from debrisflow.case import load_case
from debrisflow.case.templates import templates
from debrisflow.run.preparation import compile_kernels, short_runs


def test_every_shipped_case_and_variant_is_run():
    runs = short_runs()
    assert {path for path, _ in runs.values()} == set(templates().values())
    assert any(changes for _, changes in runs.values())
    for path, changes in runs.values():
        load_case(path, changes)


def test_what_is_compiled_once_is_not_compiled_again(tank):
    compile_kernels(tank, ())
    assert compile_kernels(tank, ()) == 0.0
