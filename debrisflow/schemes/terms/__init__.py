"""The terms of a step: each observes the particles, limits the time step, and acts."""
