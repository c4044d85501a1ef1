"""Names of the files and folders in the folder of a study."""

from __future__ import annotations

MEMBERS = "members"
PLAN = "study.json"
WRITTEN = "written.json"
TABLE = "members.csv"
MAPS = "maps"
SENSITIVITY = "sensitivity"
EFFECTS = "effects.csv"
CALIBRATION = "calibration"
FINDINGS = "findings.txt"
REPORT = "report.html"
ARRIVAL = "arrival"  # the layer of times
