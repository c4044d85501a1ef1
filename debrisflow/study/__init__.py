"""Many runs of one case: designs, members, maps of probability, sensitivity, calibration."""
