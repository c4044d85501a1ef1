"""Progress bars: redrawn on a terminal, whole lines in a file."""

import io

import pytest

from debrisflow.run import bar


class Terminal(io.StringIO):
    def isatty(self):
        return True


def drawn(stream, monkeypatch):
    """Return what a bar of three steps writes to a stream as the standard error."""
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr(bar, "PAUSE", 0.0)
    monkeypatch.setattr(bar, "PAUSE_IN_FILE", 0.0)
    for _ in bar.bar(range(3), desc="steps"):
        pass
    return stream.getvalue()


def test_a_log_has_lines_and_no_carriage_returns(monkeypatch):
    lines = drawn(io.StringIO(), monkeypatch).splitlines()
    assert len(lines) >= 2
    assert all(line.startswith("steps") for line in lines)
    assert "3/3" in lines[-1]


def test_a_terminal_has_one_line_that_is_drawn_again(monkeypatch):
    text = drawn(Terminal(), monkeypatch)
    assert text.count("\r") >= 2
    assert text.count("\n") == 1


@pytest.mark.parametrize(("stream", "pause"), [(Terminal(), 0.5), (io.StringIO(), 30.0)])
def test_a_file_gets_fewer_drawings(monkeypatch, stream, pause):
    monkeypatch.setattr("sys.stderr", stream)
    assert bar.pause() == pause
