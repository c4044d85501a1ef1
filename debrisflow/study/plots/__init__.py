"""Pictures of what the parameters of a study do to its quantities."""
