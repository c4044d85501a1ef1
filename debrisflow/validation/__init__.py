"""Published experiments and closed forms that the program is compared with on any machine."""
