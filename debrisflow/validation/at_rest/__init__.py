"""Water at rest."""
