"""The page on a whole study."""

import os
import re
from html.parser import HTMLParser
from urllib.parse import unquote

import numpy as np
import pytest

from debrisflow.study.attachments import MOST_ROWS, attachments
from debrisflow.study.member import Member
from debrisflow.study.outcome import FAILED, FINISHED, Figure, Outcome
from debrisflow.study.quantities import is_early
from debrisflow.study.report import study_report
from debrisflow.study.results import Results
from debrisflow.study.statistics import summary
from debrisflow.study.tables import Quantity, Study
from tests.recording import channel_case

PNG = b"\x89PNG\r\n\x1a\n"
HOSTILE = "<img src=x onerror=alert(1)></td><script>alert(2)</script>{{ 7 * 7 }}"
FRICTION = {"name": "friction", "key": "walls.floor.roughness", "distribution": "uniform"}
FRICTION |= {"low": 0.1, "high": 0.2}
VOLUME = {"name": "volume", "key": "fill.0.x", "distribution": "lognormal", "is_factor": True}
VOLUME |= {"median": 1.0, "deviation": 0.3}
LATIN = {"type": "latin-hypercube", "members": 5, "seed": 7}
RUNOUT = [10.0, 40.0, 20.0, 30.0]  # of the members that finish; the fifth fails


def study_of(**tables):
    """Return a study of a case in a channel."""
    return Study(
        **{
            "title": "a study",
            "notes": "Source: nobody.\n\nChosen: all.",
            "case": "/somewhere/secret/base.toml",
            "set": {"particles": {"spacing": 0.02}},
            "parameter": [FRICTION, VOLUME],
            "correlation": [{"parameters": ["friction", "volume"], "coefficient": -0.5}],
            "design": LATIN,
            "quantity": [{"answer": "runout_length"}, {"answer": "dam_arrival"}],
        }
        | tables
    )


def results_of(folder, study, message="it <diverged>", runout=RUNOUT):
    """Return results of four members and one that failed, whose folders are there."""
    members, outcomes = [], []
    for number in range(len(runout) + 1):
        values = {"friction": 0.1 + 0.02 * number, "volume": 1.0 + number}
        member = folder / "members" / f"{number:016x}"
        members.append(Member(number, values, channel_case(), f"{number:064x}", member))
        if number == len(runout):
            outcomes.append(Outcome(FAILED, message, {}, 1.0))  # its case: it has no folder
            continue
        (member / "postprocess").mkdir(parents=True)
        answers = {
            "runout_length": Figure(runout[number], "m"),
            "dam_arrival": Figure(np.nan if number == 3 else 5.0 - number, "s"),
        }
        outcomes.append(Outcome(FINISHED, "", answers, 60.0))
    return Results(study, channel_case(), members, outcomes)


def page_of(folder, **known):
    """Return the text of the page of a study in a folder."""
    study = known.pop("study", None) or study_of()
    written = known.pop("written", sorted(folder.rglob("*")))
    return study_report(results_of(folder, study, **known), folder, written).read_text("utf-8")


class Reader(HTMLParser):
    """Follows which elements are open, and collects links, scripts, handlers and anchors."""

    VOID = ("meta", "img")

    def __init__(self, page):
        super().__init__()
        self.open, self.links, self.anchors, self.tags, self.handlers = [], [], set(), set(), []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        known = dict(attrs)
        self.handlers += [name for name in known if name.startswith("on")]
        if "href" in known:
            self.links.append(known["href"])
        if "id" in known:
            self.anchors.add(known["id"])
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture
def filled(tmp_path):
    """Return the folder of a study with all that its analyses may leave."""
    for name in ("sensitivity", "maps", "calibration"):
        (tmp_path / name).mkdir()
        (tmp_path / name / f"{name}_plot.png").write_bytes(PNG)
    (tmp_path / "sensitivity/indices.csv").write_text(
        "# S1: share alone\nquantity,parameter,S1\nrunout_length,friction,0.8123456\n"
    )
    (tmp_path / "maps/convergence.csv").write_text("members,change\n4.0,0.25\n")
    (tmp_path / "maps/p_peak depth.tif").write_bytes(b"II*\0")
    (tmp_path / "calibration/posterior.csv").write_text("parameter,low,high\nfriction,0.1,0.12\n")
    (tmp_path / "calibration/maps").mkdir()
    (tmp_path / "calibration/maps/later.png").write_bytes(PNG)
    (tmp_path / "members.csv").write_text("number\n0.0\n")
    return tmp_path


def row(page, name):
    """Return the cells of the row of a table that begins with a name."""
    found = re.search(rf"<tr><td class=\"name\">{name}</td>(.*?)</tr>", page, re.S)
    return re.findall(r"<td[^>]*>(.*?)</td>", found[1], re.S)


def test_a_page_says_what_was_asked(tmp_path):
    page = page_of(tmp_path)
    assert "<title>a study</title>" in page
    assert '<p class="lines">Source: nobody.</p>' in page
    assert "<code>base.toml</code>" in page
    assert "secret" not in page
    assert row(page, "particles.spacing") == ["0.02"]
    assert row(page, "friction")[:2] == ["walls.floor.roughness", "uniform from 0.1 to 0.2"]
    assert row(page, "friction")[2] == "0.1 to 0.18"
    assert row(page, "volume")[0] == "fill.0.x, multiplied"
    assert "friction and volume have a correlation of -0.5" in page
    assert "latin-hypercube: members = 5, seed = 7" in page
    assert row(page, "seed of the design") == ["7"]


def test_members_without_results_are_counted_and_shown(tmp_path):
    page = page_of(tmp_path)
    assert row(page, "finished") == ["4"]
    assert row(page, "failed") == ["1"]
    assert "1 of 5 members have no results" in page
    shown = page.partition("Members without results")[2].partition("</table>")[0]
    assert "friction = 0.18, volume = 5" in shown
    assert "href" not in shown
    assert "it &lt;diverged&gt;" in shown


def test_quantities_are_over_the_members_that_have_them(tmp_path):
    page = page_of(tmp_path)
    whole = ["m", "4", "25", "12.91", "11.5", "25", "38.5", "10", "40"]
    assert row(page, "runout length") == whole
    assert row(page, "dam arrival")[:3] == ["s", "3", "4"]


def test_the_worst_and_the_median_member_are_linked(tmp_path):
    (tmp_path / f"members/{1:016x}/postprocess").mkdir(parents=True)
    study = study_of()
    results = results_of(tmp_path / "study", study)
    (results.members[1].folder / "postprocess/report.html").write_text("<p>")
    page = study_report(results, tmp_path / "study", []).read_text()
    worst = page.partition("The worst and the median member")[2]
    assert f'<a href="members/{1:016x}/">1</a>' in row(worst, "runout length")[0]
    assert f'<a href="members/{1:016x}/postprocess/report.html">' in row(worst, "runout length")[0]
    assert row(worst, "runout length")[1] == "40"
    assert f'<a href="members/{2:016x}/">2</a>' in row(worst, "runout length")[3]
    assert row(worst, "dam arrival")[1] == "3"  # the earliest is the worst
    assert "of dam_arrival the least" in worst


def test_a_page_shows_what_the_analyses_left(filled):
    page = page_of(filled)
    for name in ("sensitivity", "maps", "calibration"):
        assert f'<h2 id="{name}">' in page
        assert f'alt="{name} plot"' in page
    assert "Maps over runs drawn from the posterior" in page
    assert 'alt="later"' in page
    assert "S1: share alone" in page
    assert "<td>0.8123</td>" in page
    assert '<a href="maps/p_peak%20depth.tif">p_peak depth.tif</a>' in page
    assert "<td>0.25</td>" in page
    assert "members.csv</a>" in page


def test_a_page_says_what_a_fit_is_compared_with(filled):
    seen = {"type": "figure", "quantity": "runout_length", "value": 25.0, "error": 2.0}
    mapped = {"type": "extent", "file": "/secret/map.gpkg", "error": 0.2}
    asked = {"runs": 8, "held_out": {"x": [0.0, 50.0]}}
    page = page_of(filled, study=study_of(observation=[seen, mapped], calibration=asked))
    assert "runout_length = 25, standard deviation of its error 2" in page
    assert "extent: map.gpkg, errors of the missed area 0.2 and of the falsely reached 0.2" in page
    assert "the observed extents in x from 0 to 50 m" in page
    assert "secret" not in page


def test_a_page_has_no_section_without_content(tmp_path):
    page = page_of(tmp_path)
    assert Reader(page).anchors == {"asked", "members", "quantities", "origin"}
    assert "<img" not in page


def test_a_page_says_what_a_probability_holds_under(tmp_path):
    drawn = page_of(tmp_path / "a")
    assert "It is not the probability that such an event happens" in drawn
    grid = study_of(design={"type": "grid", "levels": 2}, correlation=[])
    assert "are no probabilities" in page_of(tmp_path / "b", study=grid)


def test_every_link_leads_somewhere_and_every_element_is_closed(filled):
    read = Reader(page_of(filled))
    assert read.open == []
    assert len(read.links) > 15
    for link in read.links:
        file, _, anchor = link.partition("#")
        assert not anchor or anchor in read.anchors
        assert (filled / unquote(file)).exists(), link


def test_runs_in_a_store_elsewhere_are_linked(tmp_path):
    results = results_of(tmp_path / "store", study_of())
    (tmp_path / "study").mkdir()
    page = study_report(results, tmp_path / "study", []).read_text()
    assert f'href="../store/members/{0:016x}/"' in page


def test_texts_of_a_study_are_shown_as_they_are(filled):
    (filled / "sensitivity/x.csv").write_text(f"# {HOSTILE}\n{HOSTILE},b\n{HOSTILE},1\n")
    (filled / "maps/'><script>.png").write_bytes(PNG)
    (filled / "maps/javascript:alert(1)").write_text("")
    study = study_of(title=HOSTILE, notes=HOSTILE, set={HOSTILE: HOSTILE}, case=f"/{HOSTILE[:20]}")
    page = page_of(filled, study=study, message=HOSTILE)
    read = Reader(page)
    assert read.open == []
    assert not {"script", "iframe", "object", "link"} & read.tags
    assert read.handlers == []
    assert not [link for link in read.links if link.startswith("javascript")]
    assert "{{ 7 * 7 }}" in page
    assert page.count("&lt;script&gt;alert(2)") >= 6


def test_a_page_asks_for_nothing_and_lets_nothing_run(filled):
    page = page_of(filled)
    policy = re.search(r'Content-Security-Policy" content="(.*?)"', page)[1]
    assert "default-src &#39;none&#39;" in policy
    assert "script-src" not in policy
    assert page.count("<img ") == page.count('src="data:image/png;base64,') == 4
    assert "http" not in page.replace("http-equiv", "")


def test_files_that_are_damaged_are_named_and_do_not_stop_the_page(filled):
    (filled / "sensitivity/bad.csv").write_bytes(b"\xff\xfe")
    (filled / "sensitivity/bad.png").write_bytes(b"no picture")
    (filled / "sensitivity/empty.csv").write_text("")
    os.mkfifo(filled / "maps/pipe.csv")
    page = page_of(filled)
    assert "bad.csv cannot be read" in page
    assert '<a href="sensitivity/bad.png">bad.png</a>' in page
    assert "pipe" not in page


def test_no_member_may_have_a_result(tmp_path):
    page = page_of(tmp_path, runout=[])
    assert "No member gives a quantity." in page
    assert row(page, "failed") == ["1"]


def test_long_tables_are_linked_and_counted_only(filled):
    text = "a,b\n" + "".join(f"row{k},1\n" for k in range(MOST_ROWS + 1))
    (filled / "calibration/posterior.csv").write_text(text)
    page = page_of(filled)
    assert f"{MOST_ROWS + 1} rows." in page
    assert "row0" not in page


def test_what_answers_stands_before_what_it_comes_from(tmp_path):
    for name in ("runs.csv", "summary.csv", "emulator.csv", "extents.csv", "x.qml"):
        (tmp_path / name).write_text("a\n1\n")
    found = attachments(tmp_path.iterdir(), tmp_path)
    assert [one.link.name for one in found.tables] == [
        "summary.csv",
        "extents.csv",
        "emulator.csv",
        "runs.csv",
    ]
    assert found.links == []


def test_pictures_stand_in_the_order_of_the_quantities(tmp_path):
    for name in ("depth_scatter", "depth_tornado", "reach_tornado", "depth_at_dam_tornado"):
        (tmp_path / f"{name}.png").write_bytes(PNG)
    found = attachments(tmp_path.iterdir(), tmp_path, ["reach", "depth", "depth_at_dam"])
    names = ["reach tornado", "depth tornado", "depth scatter", "depth at dam tornado"]
    assert [one.name for one in found.pictures] == names


def test_the_same_notes_are_not_said_twice(tmp_path):
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text("# what it is\nx\n1\n")
    assert [one.notes for one in attachments(tmp_path.iterdir(), tmp_path).tables] == [
        ["what it is"],
        [],
    ]


def test_files_of_a_former_study_are_not_shown(filled):
    page = page_of(filled, written=[filled / "maps/convergence.csv"])
    assert Reader(page).anchors == {"asked", "members", "quantities", "maps", "origin"}
    assert "<img" not in page
    assert "p_peak" not in page


def test_a_quantity_that_no_member_has():
    found = summary("x", "m", np.array([np.nan, np.nan]))
    assert found.count == 0
    assert np.isnan(found.mean)
    assert found.worst is None


def test_one_member_has_no_deviation():
    assert np.isnan(summary("x", "m", np.array([1.0, np.nan])).deviation)


def test_times_at_which_something_comes_are_known():
    place = {"name": "town", "at": [0.0, 0.0]}
    assert is_early(Quantity(layer="arrival", **place))
    assert not is_early(Quantity(layer="peak_depth", **place))
    assert is_early(Quantity(answer="dam_overtopping_time"))
    assert not is_early(Quantity(answer="runout_length"))
