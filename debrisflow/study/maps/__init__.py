"""Maps over the members of a study: probabilities, quantiles, and whether they converge."""
