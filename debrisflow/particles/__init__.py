"""What there is: the record of the particles, its start, supply and state."""
