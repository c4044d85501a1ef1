"""``python -m debrisflow`` is the command ``debrisflow``."""

from debrisflow.cli import main

main(prog_name="debrisflow")
