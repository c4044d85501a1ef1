"""Events in the field."""
