"""Dam breaks, jets, and what strikes a wall."""
